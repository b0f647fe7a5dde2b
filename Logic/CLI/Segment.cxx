#include "CLI/Command.h"
#include "CLI/Interrupt.h"
#include "CLI/Options.h"

#include "Core/Base/Error.h"
#include "Core/Features/FeatureQuery.h"
#include "Core/Features/FeatureTraining.h"
#include "Core/Image/Components.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/OutputFiles.h"
#include "IO/SegmentNames.h"
#include "Text/SegmentSearch.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

namespace innergs::cli {
namespace {

struct SegmentOptions {
  std::string model, labels, names, output, score, saveModel;
  std::vector<std::string> queries;
  GridOptions grid;
  FeatureTraining training;
  Settings settings; // threads
  double threshold = 0, minimumSize = 0;
  bool sparse = false, largest = false, quiet = false;
};

/// A segment to write: the classes that it joins.
struct Wanted {
  std::string name;
  std::vector<int> classes;
};

std::vector<SegmentName> namesFor(const SegmentOptions& o) {
  std::vector<SegmentName> names = readSegmentNames(o.names.empty() ? o.labels : o.names);
  if (names.empty())
    throw Error(
        ErrorCode::InvalidArgument,
        "The segments of " + innergs::quoted(o.labels) +
            " have no names: give a file with them as --names, e.g. {\"1\": \"liver\", \"2\": \"spleen\"}.");
  return names;
}

void remarkOnEmptySlices(const SegmentOptions& o, const Labelmap& labels) {
  const Labelmap sparse = withSparseSlices(labels);
  const auto empty = std::count(sparse.labelled.begin(), sparse.labelled.end(), 0);
  if (2 * empty > static_cast<std::int64_t>(sparse.labelled.size()))
    fmt::print(
        stderr,
        "innergs: {} of {} slices of {} hold no label and count as background; give --sparse if nobody "
        "labelled them.\n",
        empty, sparse.labelled.size(), innergs::quoted(o.labels));
}

FeatureModel learn(const SegmentOptions& o, const GaussianField& field, const Interrupt& interrupt) {
  const std::vector<SegmentName> names = namesFor(o);
  Labelmap labels = labelmapOf(readVolume(o.labels));
  if (o.sparse)
    labels = withSparseSlices(labels);
  else if (!o.quiet)
    remarkOnEmptySlices(o, labels);
  FeatureTraining training = o.training;
  training.threads = o.settings.threads;
  training.stop = interrupt.token();
  int shown = 0;
  if (!o.quiet)
    training.progress = [&](double fraction) {
      const int percent = static_cast<int>(100 * fraction);
      if (percent < shown + 10) return;
      shown = percent - percent % 10;
      fmt::print(stderr, "Learning features {} %\n", shown);
    };
  return trainFeatures(field, labels, names, training);
}

/// The segments that the queries ask for; prints what each was understood as. Throws where none is there.
std::vector<Wanted> answer(const SegmentOptions& o, const FeatureModel& features) {
  std::vector<NamedSegment> scene;
  for (int c = 1; c < features.classes(); ++c)
    scene.push_back({features.names[static_cast<std::size_t>(c)], true});
  const SegmentSearch search(Lexicon::standard(), scene);
  std::vector<Wanted> wanted;
  std::string last;
  for (const std::string& query : o.queries) {
    const SegmentAnswer found = search.find(query);
    last = found.sentence;
    const bool any = found.kind == AnswerKind::Found || found.kind == AnswerKind::Several;
    if (any || o.queries.size() > 1) fmt::print(stderr, "{}\n", found.sentence);
    const auto classOf = [&](std::size_t n) { return found.candidates[n].segment + 1; };
    if (found.kind == AnswerKind::Found) {
      Wanted one{found.leading == 1 ? scene[static_cast<std::size_t>(classOf(0) - 1)].name : query, {}};
      for (std::size_t n = 0; n < found.leading; ++n)
        one.classes.push_back(classOf(n));
      wanted.push_back(std::move(one));
    } else if (found.kind == AnswerKind::Several) { // never one of them alone
      for (std::size_t n = 0; n < found.leading; ++n)
        wanted.push_back({scene[static_cast<std::size_t>(classOf(n) - 1)].name, {classOf(n)}});
    }
  }
  if (wanted.empty())
    throw Error(ErrorCode::NoData,
                o.queries.size() == 1 ? last : "None of the queries names a segment of this model.");
  return wanted;
}

SegmentInfo infoOf(const Wanted& wanted, std::uint16_t label) {
  SegmentInfo info;
  info.name = {label, wanted.name};
  const double hue = std::fmod(0.61803398875 * label, 1.0) * 6; // far apart for neighbouring labels
  const auto channel = [&](double shift) {
    return 0.35 + 0.6 * std::clamp(std::abs(std::fmod(hue + shift, 6.0) - 3) - 1, 0.0, 1.0);
  };
  info.color = {channel(0), channel(4), channel(2)};
  const Lexicon& lexicon = Lexicon::standard();
  const auto read = interpret(lexicon, wanted.name);
  if (!read.empty() && read[0].score == 1 && read[0].structures.size() == 1) {
    const Structure& structure = read[0].structures[0];
    info.code = lexicon.codeOf(structure);
    info.meaning = lexicon.meaningOf(structure);
    info.side = static_cast<int>(structure.side);
  }
  return info;
}

/// Where a segment lies, after the options of its parts.
std::vector<std::uint8_t> maskOf(const SegmentOptions& o, const ClassImage& image, const Wanted& wanted,
                                 const std::vector<float>& score, const std::stop_token& stop) {
  std::vector<std::uint8_t> mask(image.classes.size());
  for (std::size_t v = 0; v < mask.size(); ++v)
    mask[v] = o.threshold > 0 ? static_cast<double>(score[v]) >= o.threshold
                              : std::find(wanted.classes.begin(), wanted.classes.end(), image.classes[v]) !=
                                    wanted.classes.end();
  const Vec3& mm = image.geometry.spacing;
  const auto least = static_cast<std::int64_t>(std::ceil(o.minimumSize / (mm[0] * mm[1] * mm[2])));
  if (o.largest || least > 1) keepParts(mask, image.geometry.size, least, o.largest, stop);
  return mask;
}

void checkUsage(const SegmentOptions& o) {
  if (o.output.empty() && o.saveModel.empty() && o.queries.empty())
    throw CLI::ValidationError("segment", "needs --query with --output, or --save-model");
  if (!o.output.empty() && o.queries.empty())
    throw CLI::ValidationError("segment", "--output needs a --query");
  if (!o.score.empty() && o.queries.size() != 1)
    throw CLI::ValidationError("segment", "--score is for a single --query");
  if (o.labels.empty() && (o.sparse || !o.names.empty() || !o.saveModel.empty()))
    throw CLI::ValidationError("segment", "--names, --sparse and --save-model go with --labels");
}

int segment(const SegmentOptions& o) {
  checkUsage(o);
  OutputFiles files;
  for (const std::string& input : {o.model, o.labels, o.names, o.grid.reference})
    files.read(input);
  files.add(o.output, OutputFiles::Kind::Volume);
  files.add(o.score, OutputFiles::Kind::Volume);
  files.add(o.saveModel, OutputFiles::Kind::Model);
  for (const std::string& query : o.queries)
    interpret(Lexicon::standard(), query); // what is no query is refused before the work starts
  Interrupt interrupt;
  ModelNotes notes;
  std::optional<FeatureModel> features;
  const Model model = readModel(o.model, &notes, &features);
  const GaussianField& field = model.field;
  if (!o.labels.empty()) features = learn(o, field, interrupt);
  if (!features)
    throw Error(ErrorCode::NoData, innergs::quoted(o.model) +
                                       " has no features yet: give labels to learn them from as "
                                       "--labels.");
  files.write(o.saveModel, [&](const auto& path) { writeModel(model, path, notes, &*features); });

  if (!o.queries.empty()) {
    const std::vector<Wanted> wanted = answer(o, *features);
    const GridGeometry grid = o.grid.choose(field.region(), field.region());
    const bool scored = !o.score.empty() || o.threshold > 0;
    checkMemory(grid.voxelCount() * static_cast<std::int64_t>(16 + 4 * wanted.size() * (scored ? 1 : 0)),
                "The labelmap");
    std::vector<std::vector<int>> sets;
    for (const Wanted& w : wanted)
      if (scored) sets.push_back(w.classes);
    FeatureQueryOptions query;
    query.threads = o.settings.threads;
    query.stop = interrupt.token();
    query.scoreSets = sets;
    const ClassImage image = classify(field, *features, grid, query);
    Volume labels{grid, std::vector<float>(image.classes.size(), 0.f)}, score{grid, {}};
    std::vector<SegmentInfo> infos;
    for (std::size_t n = 0; n < wanted.size(); ++n) {
      const auto mask =
          maskOf(o, image, wanted[n], scored ? image.scores[n] : std::vector<float>{}, interrupt.token());
      std::int64_t voxels = 0;
      for (std::size_t v = 0; v < mask.size(); ++v) {
        if (mask[v]) labels.voxels[v] = static_cast<float>(n + 1);
        voxels += mask[v];
      }
      infos.push_back(infoOf(wanted[n], static_cast<std::uint16_t>(n + 1)));
      const Vec3& mm = grid.spacing;
      if (!o.quiet)
        fmt::print(stderr, "{}: label {}, {} voxels, {:.1f} ml\n", wanted[n].name, n + 1, voxels,
                   static_cast<double>(voxels) * mm[0] * mm[1] * mm[2] / 1000);
      if (scored) { // of several segments, the likeliest
        score.voxels.resize(labels.voxels.size(), 0.f);
        for (std::size_t v = 0; v < score.voxels.size(); ++v)
          score.voxels[v] = std::max(score.voxels[v], image.scores[n][v]);
      }
    }
    const OutputType type = wanted.size() > 255 ? OutputType::UInt16 : OutputType::UInt8;
    files.write(o.output, [&](const auto& path) {
      writeVolume(labels, path, type, {},
                  fullExtension(path) == ".nrrd" ? segmentFields(infos, grid)
                                                 : std::map<std::string, std::string>{});
    });
    files.write(o.score, [&](const auto& path) { writeVolume(score, path); });
  }
  files.check();
  if (!o.quiet && !files.written().empty()) fmt::print(stderr, "Wrote {}.\n", files.written());
  return Success;
}

} // namespace

Subcommand addSegment(CLI::App& app) {
  auto* command = app.add_subcommand("segment", "Segments of a model by what they are called");
  auto o = std::make_shared<SegmentOptions>();
  command->add_option("model", o->model, "Model (.innergs)")->required()->type_name("MODEL");
  auto* labels =
      command
          ->add_option("--labels", o->labels,
                       "Labelmap or segmentation (.seg.nrrd) to learn from, on a grid of its own; not "
                       "needed for a model that was saved with features")
          ->type_name("IMAGE");
  command
      ->add_option(
          "--names", o->names,
          "Names of the labels: JSON, {\"1\": \"liver\", \"2\": \"spleen\"}, or a .seg.nrrd [those in the "
          "labels' own header]")
      ->type_name("FILE")
      ->needs(labels);
  command->add_flag("--sparse", o->sparse,
                    "Slices without any label between labelled ones were not labelled: they "
                    "follow the image");
  command
      ->add_option("--query", o->queries,
                   "A structure, in words, e.g. \"left kidney\"; again for more segments")
      ->type_name("TEXT")
      ->allow_extra_args(false);
  command
      ->add_option("-o,--output", o->output,
                   "Labelmap to write: .nii, .nii.gz, .mha or, with names, .seg.nrrd")
      ->type_name("FILE");
  command->add_option("--score", o->score, "Volume to write: the probability of the query at each voxel")
      ->type_name("FILE");
  command->add_option("--save-model", o->saveModel, "Model to write, with what was learned (.innergs)")
      ->type_name("FILE");
  command
      ->add_option("--threshold", o->threshold,
                   "Voxels with at least this probability [where it is the likeliest]")
      ->type_name("P")
      ->check(CLI::Range(0.01, 1.0));
  command->add_flag("--largest", o->largest, "Only the largest connected part of each segment");
  command->add_option("--minimum-size", o->minimumSize, "Only connected parts of at least so many mm3 [0]")
      ->type_name("MM3")
      ->check(CLI::NonNegativeNumber);
  o->grid.add(*command, "the grid that was fitted");
  command->add_option("--channels", o->training.channels, "Channels of a latent: 8, 16 or 32 [16]")
      ->type_name("N")
      ->check(CLI::IsMember({8, 16, 32}));
  addSetting(*command, o->settings, "threads");
  command->add_flag("-q,--quiet", o->quiet, "Say what was found and nothing else");
  command->footer(
      "Research software: the segments are as good as the labels, and no diagnosis.\n"
      "Examples:\n"
      "  innergs segment ct.innergs --labels organs.seg.nrrd --query liver -o liver.seg.nrrd\n"
      "  innergs segment ct.innergs --labels every5th.nii.gz --names names.json --sparse --save-model "
      "named.innergs\n"
      "  innergs segment named.innergs --query \"left kidney\" --query ribs -o found.nii.gz");
  return {command, [o] { return segment(*o); }};
}

} // namespace innergs::cli
