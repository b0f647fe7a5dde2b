#include "Cuda/Features.h"

#include <numeric>

namespace innergs::cuda {
namespace {

template <class T>
void upload(Buffer<T>& buffer, const std::vector<T>& values) {
  buffer.upload(values.data(), static_cast<std::int64_t>(values.size()));
}

void clear(Buffer<float>& buffer, std::int64_t count) {
  buffer.reserve(count);
  buffer.fill(0, count);
}

} // namespace

Features::Features(std::unique_ptr<Executor> executor, const FeatureProblem& problem)
    : executor_(std::move(executor)), channels_(problem.channels), rows_(std::ssize(problem.rows->voxels)),
      gaussians_(problem.rows->columns()), classes_(std::ssize(problem.codes) / (kTerms * problem.channels)),
      rowStart_(*executor_), columnStart_(*executor_), blocks_(*executor_), listStart_(*executor_),
      offsets_(*executor_), entryBlock_(*executor_), blockStart_(*executor_), blockRows_(*executor_),
      chunkStart_(*executor_), classStart_(*executor_), entryPlace_(*executor_), lists_(*executor_),
      targets_(*executor_), rowEntries_(*executor_), columnEntries_(*executor_), ranks_(*executor_),
      shares_(*executor_), latents_(*executor_), codes_(*executor_), features_(*executor_),
      differences_(*executor_), gradients_(*executor_), partial_(*executor_), sums_(*executor_),
      latentMoment1_(*executor_), latentMoment2_(*executor_), codeMoment1_(*executor_),
      codeMoment2_(*executor_) {
  const FeatureRows& rows = *problem.rows;
  upload(rowStart_, rows.rowStart);
  upload(columnStart_, rows.columnStart);
  upload(rowEntries_, rows.rowEntries);
  upload(columnEntries_, rows.columnEntries);
  upload(ranks_, problem.ranks);
  upload(blocks_, problem.blocks);

  // The classes of every block, and the rows in it.
  const std::int64_t blocks = problem.lists->blocks();
  std::vector<std::int64_t> listStart{0}, blockStart(static_cast<std::size_t>(blocks) + 1, 0), offsets;
  std::vector<std::uint16_t> lists;
  for (std::int64_t b = 0; b < blocks; ++b) {
    const auto classes = problem.lists->of(b);
    lists.insert(lists.end(), classes.begin(), classes.end());
    listStart.push_back(std::ssize(lists));
  }
  std::int64_t differences = 0;
  for (const std::int64_t b : problem.blocks) {
    ++blockStart[b + 1];
    offsets.push_back(differences);
    differences += listStart[b + 1] - listStart[b];
  }
  std::partial_sum(blockStart.begin(), blockStart.end(), blockStart.begin());
  std::vector<std::int64_t> blockRows(static_cast<std::size_t>(rows_)),
      next(blockStart.begin(), blockStart.end() - 1);
  for (std::int64_t row = 0; row < rows_; ++row)
    blockRows[next[problem.blocks[row]]++] = row;
  upload(listStart_, listStart);
  upload(lists_, lists);
  upload(offsets_, offsets);
  upload(blockStart_, blockStart);
  upload(blockRows_, blockRows);

  // For every class in turn, its places in the lists of blocks with rows, divided into chunks.
  struct Entry {
    std::int64_t block;
    std::int32_t place;
  };
  std::vector<std::vector<Entry>> entriesOf(static_cast<std::size_t>(classes_));
  for (std::int64_t b = 0; b < blocks; ++b)
    for (std::int64_t n = listStart[b]; blockStart[b] < blockStart[b + 1] && n < listStart[b + 1]; ++n)
      entriesOf[lists[n]].push_back({b, static_cast<std::int32_t>(n - listStart[b])});
  std::vector<std::int64_t> entryBlock, chunkStart, classStart{0};
  std::vector<std::int32_t> entryPlace;
  for (const std::vector<Entry>& entries : entriesOf) {
    for (std::size_t n = 0; n < entries.size(); ++n) {
      if (n % kCodeChunk == 0) chunkStart.push_back(std::ssize(entryBlock));
      entryBlock.push_back(entries[n].block);
      entryPlace.push_back(entries[n].place);
    }
    classStart.push_back(std::ssize(chunkStart));
  }
  chunks_ = std::ssize(chunkStart);
  entries_ = std::ssize(entryBlock);
  chunkStart.push_back(entries_);
  upload(entryBlock_, entryBlock);
  upload(entryPlace_, entryPlace);
  upload(chunkStart_, chunkStart);
  upload(classStart_, classStart);

  std::vector<std::uint16_t> targets;
  std::vector<float> shares;
  for (const SoftLabel& label : problem.labels) {
    targets.insert(targets.end(), label.classes.begin(), label.classes.end());
    shares.insert(shares.end(), label.shares.begin(), label.shares.end());
  }
  upload(targets_, targets);
  upload(shares_, shares);
  const std::int64_t latents = std::ssize(problem.latents), codes = std::ssize(problem.codes);
  latents_.upload(problem.latents.data(), latents);
  codes_.upload(problem.codes.data(), codes);
  clear(latentMoment1_, latents);
  clear(latentMoment2_, latents);
  clear(codeMoment1_, codes);
  clear(codeMoment2_, codes);
  features_.reserve(rows_ * channels_);
  gradients_.reserve(rows_ * channels_);
  differences_.reserve(differences);
  partial_.reserve(entries_ * kTerms * channels_);
  sums_.reserve(chunks_ * kTerms * channels_);
}

void Features::step(const FeatureStep& step) {
  const int size = kTerms * channels_;
  executor_->runOver(FeatureGradients{rows_, channels_, rowStart_.data(), rowEntries_.data(), latents_.data(),
                                      codes_.data(), ranks_.data(), blocks_.data(), listStart_.data(),
                                      lists_.data(), targets_.data(), shares_.data(), offsets_.data(),
                                      features_.data(), differences_.data(), gradients_.data()},
                     rows_);
  executor_->runOver(CodeGradients{entries_, channels_, entryBlock_.data(), entryPlace_.data(),
                                   blockStart_.data(), blockRows_.data(), offsets_.data(), ranks_.data(),
                                   features_.data(), differences_.data(), partial_.data()},
                     entries_ * size);
  executor_->runOver(SumCodeChunks{chunks_, size, chunkStart_.data(), partial_.data(), sums_.data()},
                     chunks_ * size);
  executor_->runOver(UpdateLatents{gaussians_, channels_, columnStart_.data(), columnEntries_.data(),
                                   gradients_.data(), step, latents_.data(), latentMoment1_.data(),
                                   latentMoment2_.data()},
                     gaussians_ * channels_);
  executor_->runOver(UpdateCodes{classes_, size, classStart_.data(), sums_.data(), step, codes_.data(),
                                 codeMoment1_.data(), codeMoment2_.data()},
                     classes_ * size);
}

void Features::download(std::span<float> latents, std::span<float> codes) {
  latents_.download(latents.data(), std::ssize(latents));
  codes_.download(codes.data(), std::ssize(codes));
}

} // namespace innergs::cuda
