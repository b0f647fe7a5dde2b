#include "Evaluation/ExperimentSegmentation.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Device/FeatureDeviceChoice.h"
#include "Core/Features/ClassProbabilities.h"
#include "Core/Job/ReconstructionJob.h"
#include "Evaluation/LabelInterpolation.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace innergs {
namespace {

using Clock = std::chrono::steady_clock;

std::string spacingText(int every) {
  if (every == 1) return "all slices";
  const int teens = every / 10 % 10;
  const char* ending = teens == 1        ? "th"
                       : every % 10 == 1 ? "st"
                       : every % 10 == 2 ? "nd"
                       : every % 10 == 3 ? "rd"
                                         : "th";
  return "every " + std::to_string(every) + ending;
}

/// The training labels: those of every k-th slice.
Labelmap everyKth(const Labelmap& truth, int k) {
  Labelmap out = truth;
  if (k == 1) return out;
  const std::int64_t plane = truth.geometry.size[0] * truth.geometry.size[1];
  out.labelled.assign(static_cast<std::size_t>(truth.geometry.size[2]), 0);
  for (std::int64_t slice = 0; slice < truth.geometry.size[2]; ++slice) {
    out.labelled[slice] = slice % k == 0;
    if (slice % k != 0) std::fill_n(out.voxels.begin() + slice * plane, plane, std::uint16_t{0});
  }
  return out;
}

std::vector<std::uint8_t> judgedSlices(const Labelmap& teacher) {
  std::vector<std::uint8_t> judged; // if all slices are labelled, all are scored
  for (const std::uint8_t labelled : teacher.labelled)
    judged.push_back(!labelled);
  return judged;
}

Labelmap labelsOf(const FeatureModel& model, const ClassImage& image) {
  Labelmap out{image.geometry, {}, {}};
  for (const std::uint16_t c : image.classes)
    out.voxels.push_back(model.labels[c]);
  return out;
}

struct Means {
  double dice = 0, iou = 0;
  int classes = 0;
};

/// The five slices with the best Dice of a class, as the paper shows slices: chosen by the score, they
/// flatter.
struct TopSlices {
  double dice = 0, iou = 0, accuracy = 0;
};

class SliceScores {
public:
  /// slices: as in agreement().
  SliceScores(const Labelmap& tested, const Labelmap& truth, const std::vector<std::uint8_t>& slices)
      : plane_(truth.geometry.size[0] * truth.geometry.size[1]) {
    std::size_t most = 0;
    for (const Labelmap* map : {&tested, &truth})
      for (const std::uint16_t label : map->voxels)
        most = std::max<std::size_t>(most, label);
    for (std::int64_t k = 0; k < truth.geometry.size[2]; ++k) {
      if (!slices.empty() && !slices[static_cast<std::size_t>(k)]) continue;
      std::vector<Counts> counts(most + 1);
      for (std::int64_t v = k * plane_; v < (k + 1) * plane_; ++v) {
        const auto at = static_cast<std::size_t>(v);
        ++counts[tested.voxels[at]].tested;
        ++counts[truth.voxels[at]].truth;
        if (tested.voxels[at] == truth.voxels[at]) ++counts[truth.voxels[at]].common;
      }
      slices_.push_back(std::move(counts));
    }
  }

  TopSlices top(std::size_t label) const {
    std::vector<TopSlices> all;
    for (const std::vector<Counts>& counts : slices_) {
      if (label >= counts.size() || counts[label].truth == 0) continue;
      const auto [tested, truth, common] = counts[label];
      const auto part = [](std::int64_t a, std::int64_t b) {
        return static_cast<double>(a) / static_cast<double>(b);
      };
      all.push_back({part(2 * common, tested + truth), part(common, tested + truth - common),
                     1 - part(tested + truth - 2 * common, plane_)});
    }
    const std::size_t count = std::min<std::size_t>(5, all.size());
    std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end(),
                      [](const auto& a, const auto& b) { return a.dice > b.dice; });
    TopSlices mean;
    for (std::size_t n = 0; n < count; ++n) {
      mean.dice += all[n].dice / static_cast<double>(count);
      mean.iou += all[n].iou / static_cast<double>(count);
      mean.accuracy += all[n].accuracy / static_cast<double>(count);
    }
    return mean;
  }

private:
  struct Counts {
    std::int64_t tested = 0, truth = 0, common = 0;
  };
  std::int64_t plane_;
  std::vector<std::vector<Counts>> slices_; // [slice][label]
};

/// Trilinear interpolation of each label's indicator; the greatest wins, of equal ones the smallest label.
Labelmap linearlyResampled(const Labelmap& labels, const GridGeometry& grid) {
  Labelmap out{grid, std::vector<std::uint16_t>(static_cast<std::size_t>(grid.voxelCount()), 0), {}};
  const Affine3 map = inverse(labels.geometry.indexToWorld()) * grid.indexToWorld();
  const auto& n = labels.geometry.size;
  std::size_t v = 0;
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i, ++v) {
        const Vec3 x = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        std::int64_t first[3];
        double part[3];
        bool inside = true;
        for (int a = 0; a < 3; ++a) {
          inside = inside && x[a] >= -0.5 && x[a] < static_cast<double>(n[a]) - 0.5;
          first[a] = static_cast<std::int64_t>(std::floor(x[a]));
          part[a] = x[a] - static_cast<double>(first[a]);
        }
        if (!inside) continue;
        std::array<std::pair<std::uint16_t, double>, 8> shares{};
        std::size_t count = 0;
        for (int corner = 0; corner < 8; ++corner) {
          double weight = 1;
          std::int64_t at[3];
          for (int a = 0; a < 3; ++a) {
            const int up = corner >> a & 1;
            weight *= up ? part[a] : 1 - part[a];
            at[a] = std::clamp<std::int64_t>(first[a] + up, 0, n[a] - 1);
          }
          const std::uint16_t label =
              labels.voxels[static_cast<std::size_t>(at[0] + n[0] * (at[1] + n[1] * at[2]))];
          std::size_t known = 0;
          while (known < count && shares[known].first != label)
            ++known;
          if (known == count) shares[count++].first = label;
          shares[known].second += weight;
        }
        const auto* best = &shares[0];
        for (std::size_t s = 1; s < count; ++s)
          if (shares[s].second > best->second ||
              (shares[s].second == best->second && shares[s].first < best->first))
            best = &shares[s];
        out.voxels[v] = best->first;
      }
  return out;
}

bool counts(const LabelAgreement& a, std::size_t label, std::int64_t least) {
  return label > 0 && a.whole[label] >= least;
}

Means meansOf(const LabelAgreement& a, std::int64_t least) {
  Means m;
  for (std::size_t label = 1; label < a.whole.size(); ++label)
    if (counts(a, label, least)) {
      m.dice += a.dice(label);
      m.iou += a.iou(label);
      ++m.classes;
    }
  m.dice /= std::max(1, m.classes);
  m.iou /= std::max(1, m.classes);
  return m;
}

std::string nameOf(const LabelSet& set, std::size_t label) {
  for (const SegmentName& name : set.names)
    if (name.label == label) return name.name;
  return std::to_string(label);
}

/// A grid inside the given one, rotated about all axes through its centre.
GridGeometry obliqueGrid(const GridGeometry& g) {
  const double a = 0.4, b = 0.3, c = 0.5;
  const Mat3 x{{{{1, 0, 0}, {0, std::cos(a), -std::sin(a)}, {0, std::sin(a), std::cos(a)}}}};
  const Mat3 y{{{{std::cos(b), 0, std::sin(b)}, {0, 1, 0}, {-std::sin(b), 0, std::cos(b)}}}};
  const Mat3 z{{{{std::cos(c), -std::sin(c), 0}, {std::sin(c), std::cos(c), 0}, {0, 0, 1}}}};
  GridGeometry out = g;
  out.direction = x * y * z * g.direction;
  out.origin = {0, 0, 0};
  out.origin = g.centre() - out.centre();
  return out;
}

class SegmentationRun {
public:
  explicit SegmentationRun(const SegmentationExperiment& e) : e_(e) {
    const std::string on = "Segmentation of " + e.volumeName + ", mean over the classes of at least " +
                           std::to_string(e.leastVoxels) + " voxels";
    result_.methods = {"segmentation",
                       on,
                       {"labels", "labelled", "classes", "method", "dice", "iou", "pixel_accuracy",
                        "top5_dice", "top5_iou", "top5_accuracy", "seconds", "measured_on"},
                       {},
                       {}};
    result_.classes = {"segmentation-classes",
                       on,
                       {"labels", "labelled", "class", "voxels", "gaussians_dice", "gaussians_iou",
                        "top5_dice", "top5_iou", "top5_accuracy", "shape_dice", "nearest_dice",
                        "measured_on"},
                       {},
                       {}};
    result_.grids = {"segmentation-grids",
                     "All slices labelled, on other grids, and every second voxel labelled",
                     {"labels", "grid", "tested", "classes", "dice", "iou", "measured_on"},
                     {},
                     {}};
    result_.queries = {"segmentation-queries",
                       "A segment's largest part once the volume's own grid was decoded",
                       {"labels", "segments", "decoding_seconds", "megabytes", "median_milliseconds",
                        "slowest_milliseconds", "slowest"},
                       {},
                       {}};
    result_.methods.notes = {
        "Dice and IoU: foreground classes alone, whole volume, on the slices that nobody labelled.",
        "All slices labelled: on these, whose labels the residual keeps; that row predicts nothing.",
        "The labels are a program's, not a person's. Settings of the completion were chosen on this CT.",
        "top5: mean over each class's five best slices, as the paper's table; chosen by the score itself.",
        "teacher: the labels as they were given, without learning anything.",
        "The paper gives a Dice of 0.8817 on CT-ORG, another data set, with complete labels."};
  }

  SegmentationResult run() {
    for (const LabelSet& set : e_.sets)
      if (!sameGrid(set.labels.geometry, e_.volume.geometry))
        throw Error(ErrorCode::InvalidArgument,
                    "The labels " + set.name +
                        " lie on another grid than the volume; give labels of this volume.");
    fit();
    for (const LabelSet& set : e_.sets)
      for (const int every : e_.every)
        compare(set, every);
    return std::move(result_);
  }

private:
  void fit() {
    say("Fitting " + e_.volumeName);
    ReconstructionInput input;
    Stack stack;
    stack.image = e_.volume;
    stack.name = e_.volumeName;
    input.stacks.push_back(std::move(stack));
    ReconstructionJob job(std::move(input), e_.settings);
    if (e_.progress) job.onProgress(e_.progress);
    const ReconstructionResult fitted = job.run(e_.stop);
    if (fitted.cancelled) throw Error(ErrorCode::Cancelled, "The experiment was cancelled.");
    fitted_ = fitted.model;
  }

  void compare(const LabelSet& set, int every) {
    say("Learning " + set.name + ", " + spacingText(every));
    const Labelmap teacher = everyKth(set.labels, every);
    const auto judged = judgedSlices(teacher);
    FeatureTraining training = e_.training;
    training.stop = e_.stop;
    training.threads = e_.settings.threads;
    training.devices = std::make_shared<FeatureDeviceChoice>(e_.settings.device);
    auto start = Clock::now();
    const FeatureModel model = trainFeatures(fitted_->field, teacher, set.names, training);
    const double seconds = secondsSince(start);
    const Labelmap ours =
        labelsOf(model, classify(fitted_->field, model, e_.volume.geometry, queryOptions()));
    const LabelAgreement gaussians = agreement(ours, set.labels, judged);
    const SliceScores slices(ours, set.labels, judged);
    addMethod(set, every, "Gaussians", gaussians, slices, seconds);
    const auto judge = [&](const char* method, const Labelmap& labels, double seconds) {
      const LabelAgreement found = agreement(labels, set.labels, judged);
      addMethod(set, every, method, found, SliceScores(labels, set.labels, judged), seconds);
      return found;
    };
    judge("teacher", teacher, 0);
    LabelAgreement shape = gaussians, nearest = gaussians;
    if (every > 1) {
      start = Clock::now();
      const Labelmap shapes = shapeBasedInterpolation(teacher);
      shape = judge("shape-based", shapes, secondsSince(start));
      start = Clock::now();
      const Labelmap copies = nearestLabelledSlice(teacher);
      nearest = judge("nearest slice", copies, secondsSince(start));
    }
    for (std::size_t label = 1; label < gaussians.whole.size(); ++label)
      if (counts(gaussians, label, e_.leastVoxels)) {
        const auto of = [&](const LabelAgreement& a) {
          return every > 1 ? decimals(a.dice(label), 4) : std::string();
        };
        result_.classes.add({set.name, spacingText(every), nameOf(set, label),
                             std::to_string(gaussians.whole[label]), decimals(gaussians.dice(label), 4),
                             decimals(gaussians.iou(label), 4), decimals(slices.top(label).dice, 4),
                             decimals(slices.top(label).iou, 4), decimals(slices.top(label).accuracy, 4),
                             of(shape), of(nearest), measuredOn(every)});
      }
    if (every == 1) {
      FeatureModel alone = model;
      alone.residual = {};
      judge("Gaussians without residual",
            labelsOf(alone, classify(fitted_->field, alone, e_.volume.geometry, queryOptions())), seconds);
      otherGrids(set, model, alone);
      everySecondVoxel(set, training);
      timeQueries(set, model);
    }
  }

  void otherGrids(const LabelSet& set, const FeatureModel& model, const FeatureModel& alone) {
    const Vec3 half = 0.5 * e_.volume.geometry.spacing;
    for (const auto& [name, grid] : {std::pair{"oblique", obliqueGrid(e_.volume.geometry)},
                                     {"half the spacing", withSpacing(e_.volume.geometry, half)}}) {
      const Labelmap ours = labelsOf(model, classify(fitted_->field, model, grid, queryOptions()));
      const Labelmap rendered = labelsOf(alone, classify(fitted_->field, alone, grid, queryOptions()));
      const Vec3 &own = e_.volume.geometry.spacing, &other = grid.spacing;
      const double finer = own[0] * own[1] * own[2] / (other[0] * other[1] * other[2]);
      // Between the labelled voxels the truth is a guess, and the last row says how far two guesses are
      // apart.
      const Labelmap nearest = resampled(set.labels, grid), linear = linearlyResampled(set.labels, grid);
      const auto add = [&, name = name](const char* tested, const Labelmap& a, const Labelmap& b,
                                        const char* on) {
        const Means m = meansOf(agreement(a, b), std::llround(static_cast<double>(e_.leastVoxels) * finer));
        result_.grids.add(
            {set.name, name, tested, std::to_string(m.classes), decimals(m.dice, 4), decimals(m.iou, 4), on});
      };
      add("Gaussians", ours, nearest, "labels by nearest neighbour");
      add("Gaussians", ours, linear, "labels by linear interpolation");
      add("Gaussians without residual", rendered, nearest, "labels by nearest neighbour");
      add("Gaussians without residual", rendered, linear, "labels by linear interpolation");
      add("labels by linear interpolation", linear, nearest, "labels by nearest neighbour");
    }
  }

  /// Only every second voxel along each axis is labelled, and those between, where there is a truth, are
  /// judged.
  void everySecondVoxel(const LabelSet& set, const FeatureTraining& training) {
    const GridGeometry& whole = set.labels.geometry;
    GridGeometry coarse = whole;
    for (int a = 0; a < 3; ++a) {
      coarse.size[a] = (whole.size[a] + 1) / 2;
      coarse.spacing[a] *= 2;
    }
    const Labelmap teacher = resampled(set.labels, coarse);
    FeatureModel model = trainFeatures(fitted_->field, teacher, set.names, training);
    const auto between = [&](Labelmap labels) {
      for (std::int64_t k = 0; k < whole.size[2]; k += 2)
        for (std::int64_t j = 0; j < whole.size[1]; j += 2)
          for (std::int64_t i = 0; i < whole.size[0]; i += 2)
            labels.voxels[static_cast<std::size_t>(i + whole.size[0] * (j + whole.size[1] * k))] = 0;
      return labels;
    };
    const Labelmap truth = between(set.labels);
    const auto add = [&](const char* tested, const Labelmap& labels) {
      const Means m = meansOf(agreement(between(labels), truth), e_.leastVoxels);
      result_.grids.add({set.name, "every second voxel labelled", tested, std::to_string(m.classes),
                         decimals(m.dice, 4), decimals(m.iou, 4), "the labels of the others"});
    };
    add("Gaussians", labelsOf(model, classify(fitted_->field, model, whole, queryOptions())));
    model.residual = {};
    add("Gaussians without residual",
        labelsOf(model, classify(fitted_->field, model, whole, queryOptions())));
    add("labels by linear interpolation", linearlyResampled(teacher, whole));
    add("labels by nearest neighbour", resampled(teacher, whole));
  }

  void timeQueries(const LabelSet& set, const FeatureModel& model) {
    auto start = Clock::now();
    const ClassProbabilities probabilities(fitted_->field, model, e_.volume.geometry, queryOptions());
    const double decoding = secondsSince(start);
    SegmentOptions options;
    options.largestOnly = true;
    std::vector<std::pair<double, int>> milliseconds;
    for (int c = 1; c < model.classes(); ++c) {
      start = Clock::now();
      probabilities.segment(std::array<int, 1>{c}, options, e_.stop);
      milliseconds.emplace_back(1000 * secondsSince(start), c);
    }
    std::sort(milliseconds.begin(), milliseconds.end());
    result_.queries.add({set.name, std::to_string(milliseconds.size()), decimals(decoding, 2),
                         decimals(static_cast<double>(probabilities.bytes()) / 1e6, 1),
                         decimals(milliseconds[milliseconds.size() / 2].first, 1),
                         decimals(milliseconds.back().first, 1),
                         model.names[static_cast<std::size_t>(milliseconds.back().second)]});
  }

  FeatureQueryOptions queryOptions() const {
    FeatureQueryOptions options;
    options.stop = e_.stop;
    options.threads = e_.settings.threads;
    return options;
  }

  static std::string measuredOn(int every) {
    return every == 1 ? "the labelled slices" : "slices not labelled";
  }

  void addMethod(const LabelSet& set, int every, const std::string& method, const LabelAgreement& a,
                 const SliceScores& slices, double seconds) {
    const Means m = meansOf(a, e_.leastVoxels);
    TopSlices top;
    for (std::size_t label = 1; label < a.whole.size(); ++label)
      if (counts(a, label, e_.leastVoxels)) {
        const TopSlices own = slices.top(label);
        top.dice += own.dice / m.classes;
        top.iou += own.iou / m.classes;
        top.accuracy += own.accuracy / m.classes;
      }
    result_.methods.add({set.name, spacingText(every), std::to_string(m.classes), method, decimals(m.dice, 4),
                         decimals(m.iou, 4), decimals(a.pixelAccuracy, 4), decimals(top.dice, 4),
                         decimals(top.iou, 4), decimals(top.accuracy, 4), decimals(seconds, 1),
                         measuredOn(every)});
  }

  void say(const std::string& line) const {
    if (e_.say) e_.say(line);
  }

  const SegmentationExperiment& e_;
  SegmentationResult result_;
  std::shared_ptr<const Model> fitted_;
};

} // namespace

SegmentationResult runSegmentation(const SegmentationExperiment& experiment) {
  return SegmentationRun(experiment).run();
}

} // namespace innergs
