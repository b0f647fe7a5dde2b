#include "Evaluation/ExperimentSegmentation.h"

#include "Core/Base/Error.h"
#include "Core/Features/ClassProbabilities.h"
#include "Core/Job/ReconstructionJob.h"
#include "Evaluation/LabelInterpolation.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace innergs {
namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string spacingText(int every) {
  return every == 1 ? "all slices"
                    : "every " + std::to_string(every) +
                          (every == 2   ? "nd"
                           : every == 3 ? "rd"
                                        : "th");
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

/// A lattice inside the given one, rotated about all axes through its centre.
GridGeometry obliqueGrid(const GridGeometry& g) {
  const double a = 0.4, b = 0.3, c = 0.5;
  const Mat3 x{{{{1, 0, 0}, {0, std::cos(a), -std::sin(a)}, {0, std::sin(a), std::cos(a)}}}};
  const Mat3 y{{{{std::cos(b), 0, std::sin(b)}, {0, 1, 0}, {-std::sin(b), 0, std::cos(b)}}}};
  const Mat3 z{{{{std::cos(c), -std::sin(c), 0}, {std::sin(c), std::cos(c), 0}, {0, 0, 1}}}};
  GridGeometry out = g;
  out.direction = x * y * z * g.direction;
  const Vec3 middle{(static_cast<double>(g.size[0]) - 1) / 2, (static_cast<double>(g.size[1]) - 1) / 2,
                    (static_cast<double>(g.size[2]) - 1) / 2};
  out.origin = {0, 0, 0};
  out.origin = g.indexToWorld()(middle) - out.indexToWorld()(middle);
  return out;
}

class Run {
public:
  explicit Run(const SegmentationExperiment& e) : e_(e) {
    const std::string on = "Segmentation of " + e.volumeName + ", mean over the classes of at least " +
                           std::to_string(e.leastVoxels) + " voxels";
    result_.methods = {"segmentation",
                       on,
                       {"labels", "labelled", "classes", "method", "dice", "iou", "pixel_accuracy", "seconds",
                        "measured_on"},
                       {},
                       {}};
    result_.classes = {"segmentation-classes",
                       on,
                       {"labels", "labelled", "class", "voxels", "gaussians_dice", "gaussians_iou",
                        "shape_dice", "nearest_dice", "measured_on"},
                       {},
                       {}};
    result_.grids = {"segmentation-grids",
                     "All slices labelled, on other grids",
                     {"labels", "grid", "classes", "dice", "iou", "measured_on"},
                     {},
                     {}};
    result_.queries = {"segmentation-queries",
                       "A segment's largest part once the volume's own grid was decoded",
                       {"labels", "segments", "decoding_seconds", "megabytes", "median_milliseconds",
                        "slowest_milliseconds", "slowest"},
                       {},
                       {}};
    result_.methods.notes = {
        "Dice and IoU: foreground classes alone, whole volume, on the slices that nobody labelled; where all "
        "slices are "
        "labelled, on these: that says how well the features keep the labels, not how well they predict.",
        "The labels are a program's, not a person's. Settings of the completion were chosen on this CT.",
        "The paper gives a Dice of 0.8817 on CT-ORG, another data set, with complete labels."};
  }

  SegmentationResult run() {
    for (const LabelSet& set : e_.sets)
      if (!sameLattice(set.labels.geometry, e_.volume.geometry))
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
    auto start = Clock::now();
    const FeatureModel model = trainFeatures(fitted_->field, teacher, set.names, training);
    const double seconds = secondsSince(start);
    FeatureQueryOptions query;
    query.stop = e_.stop;
    query.threads = e_.settings.threads;
    const Labelmap ours = labelsOf(model, classify(fitted_->field, model, e_.volume.geometry, query));
    const LabelAgreement gaussians = agreement(ours, set.labels, judged);
    addMethod(set, every, "Gaussians", gaussians, seconds);
    LabelAgreement shape = gaussians, nearest = gaussians;
    if (every > 1) {
      start = Clock::now();
      shape = agreement(shapeBasedInterpolation(teacher), set.labels, judged);
      addMethod(set, every, "shape-based", shape, secondsSince(start));
      start = Clock::now();
      nearest = agreement(nearestLabelledSlice(teacher), set.labels, judged);
      addMethod(set, every, "nearest slice", nearest, secondsSince(start));
    }
    for (std::size_t label = 1; label < gaussians.whole.size(); ++label)
      if (counts(gaussians, label, e_.leastVoxels)) {
        const auto of = [&](const LabelAgreement& a) {
          return every > 1 ? decimals(a.dice(label), 4) : std::string();
        };
        result_.classes.add({set.name, spacingText(every), nameOf(set, label),
                             std::to_string(gaussians.whole[label]), decimals(gaussians.dice(label), 4),
                             decimals(gaussians.iou(label), 4), of(shape), of(nearest), measuredOn(every)});
      }
    if (every == 1) {
      otherGrids(set, model);
      timeQueries(set, model);
    }
  }

  void otherGrids(const LabelSet& set, const FeatureModel& model) {
    const Vec3 half = 0.5 * e_.volume.geometry.spacing;
    for (const auto& [name, grid] : {std::pair{"oblique", obliqueGrid(e_.volume.geometry)},
                                     {"half the spacing", withSpacing(e_.volume.geometry, half)}}) {
      FeatureQueryOptions query;
      query.stop = e_.stop;
      query.threads = e_.settings.threads;
      const Labelmap ours = labelsOf(model, classify(fitted_->field, model, grid, query));
      const Vec3 &own = e_.volume.geometry.spacing, &other = grid.spacing;
      const double finer = own[0] * own[1] * own[2] / (other[0] * other[1] * other[2]);
      const Means m = meansOf(agreement(ours, resampled(set.labels, grid)),
                              std::llround(static_cast<double>(e_.leastVoxels) * finer));
      result_.grids.add({set.name, name, std::to_string(m.classes), decimals(m.dice, 4), decimals(m.iou, 4),
                         "labelled voxels, nearest neighbour"});
    }
  }

  void timeQueries(const LabelSet& set, const FeatureModel& model) {
    FeatureQueryOptions query;
    query.stop = e_.stop;
    query.threads = e_.settings.threads;
    auto start = Clock::now();
    const ClassProbabilities probabilities(fitted_->field, model, e_.volume.geometry, query);
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

  static std::string measuredOn(int every) {
    return every == 1 ? "the labelled slices" : "slices not labelled";
  }

  void addMethod(const LabelSet& set, int every, const std::string& method, const LabelAgreement& a,
                 double seconds) {
    const Means m = meansOf(a, e_.leastVoxels);
    result_.methods.add({set.name, spacingText(every), std::to_string(m.classes), method, decimals(m.dice, 4),
                         decimals(m.iou, 4), decimals(a.pixelAccuracy, 4), decimals(seconds, 1),
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
  return Run(experiment).run();
}

} // namespace innergs
