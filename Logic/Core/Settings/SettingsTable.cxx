#include "Core/Settings/SettingsTable.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Translation.h"
#include "Core/Settings/DeviceRequest.h"

#include <algorithm>

namespace innergs {
namespace {

#define MEMBER(path) settingMember([](auto& s) -> auto& { return s.path; })

constexpr SettingRange between(double lowest, double highest) {
  return {lowest, highest};
}
constexpr SettingRange nonNegative{.lowest = 0}, positive{.lowest = 0, .open = true};
constexpr SettingRange insideUnit{0, 1, true, true}, belowOne{0, 1, false, true};

bool plateaus(const Settings& s) {
  return s.schedule == Schedule::Plateau;
}
bool densifies(const Settings& s) {
  return s.densifyEvery.value_or(0) > 0;
}
bool movesSlices(const Settings& s) {
  return s.sliceMotion != SliceMotionKind::Off;
}
bool refines(const Settings& s) {
  return s.kind != DynamicKind::Intensity;
}
bool mayCarry(const Settings& s) {
  return s.kind.value_or(DynamicKind::Motion) == DynamicKind::Motion;
}
bool mayChange(const Settings& s) {
  return s.kind.value_or(DynamicKind::Intensity) == DynamicKind::Intensity;
}

} // namespace

const std::vector<Setting>& settingsTable() {
  using enum Setting::Group;
  constexpr auto Result = Setting::Part::Result, Speed = Setting::Part::Speed;
  static const std::vector<Setting> rows{
      Setting(
          "preset", MEMBER(preset), Basic, tr("Preset"),
          tr("How much time to spend: seconds, about a minute, or minutes; or the paper's own method, unless "
             "another setting overrides it."),
          {.words = {{"fast", tr("Fast"), tr("Fast, for a first look.")},
                     {"balanced", tr("Balanced"), tr("The usual choice: good quality without a long wait.")},
                     {"best", tr("Best"), tr("The best quality: somewhat better, several times slower.")},
                     {"paper", tr("Paper"),
                      tr("The published method, for comparison: slow, and poor between slices.")}}}),
      Setting(
          "device", MEMBER(device), Basic, tr("Device"),
          tr("Where the fit runs: auto (a GPU, if there is one with enough memory), cpu, cuda or cuda:N."),
          {.part = Result,
           .checkText = [](const std::string& text) { parseDeviceRequest(text); },
           .dynamic = true}),
      Setting("fill", MEMBER(fill), Basic, tr("Outside the mask"),
              tr("Value of the volume, and of every later query of the model, outside the mask."),
              {.part = Result, .range = between(-1e30, 1e30)}),

      Setting("blending", MEMBER(blending), Model, tr("Blending"),
              tr("How overlapping Gaussians add up: their weighted mean, their sum, or one behind the other "
                 "along the slices, as in the paper."),
              {.words = {{"normalised", tr("normalised")},
                         {"additive", tr("additive")},
                         {"alpha", tr("alpha")}}}),
      Setting("linearIntensity", MEMBER(linearIntensity), Model, tr("Linear intensity"),
              tr("Each Gaussian's intensity may vary linearly across it (normalised blending only)."),
              {.automatic = tr("chosen from the data")}),
      Setting("cutoff", MEMBER(cutoff), Model, tr("Cut-off radius"),
              tr("The radius at which Gaussians end, in standard deviations; the paper uses 3."),
              {.range = between(1, 5), .unit = tr("σ")}),
      Setting("initialisation", MEMBER(initialisation), Model, tr("Start"),
              tr("Where Gaussians start: where the structure is, or on an even grid."),
              {.words = {{"adaptive", tr("adaptive")}, {"grid", tr("even grid")}}}),
      Setting("gaussians", MEMBER(gaussians), Model, tr("Gaussians"),
              tr("Number of Gaussians in one field at its start."),
              {.range = between(1, 1e9),
               .automatic = tr("chosen from the data"),
               .usual = 10000,
               .dynamic = true}),
      Setting("ensembleSize", MEMBER(ensembleSize), Model, tr("Merged fields"),
              tr("Number of fields fitted independently and merged: more are slower, but less noisy between "
                 "slices."),
              {.range = between(1, 64), .automatic = tr("chosen from preset and gap"), .usual = 1}),

      Setting("iterations", MEMBER(iterations), Fit, tr("Iterations"),
              tr("Iterations over the data, for each field."),
              {.range = between(1, 1e6), .automatic = tr("chosen from preset and data"), .usual = 100}),
      Setting("loss", MEMBER(loss), Fit, tr("Loss"), tr("What the fit minimises between scan and model."),
              {.words = {{"l1", tr("L1")}, {"l2", tr("L2")}, {"huber", tr("Huber")}}}),
      Setting("lossWeight", MEMBER(lossWeight), Fit, tr("Weight of the loss"),
              tr("Weight of the loss relative to that of 1 − SSIM."), {.range = nonNegative}),
      Setting("ssimWeight", MEMBER(ssimWeight), Fit, tr("Weight of 1 − SSIM"),
              tr("Weight of structural dissimilarity relative to the loss."),
              {.range = nonNegative, .usual = 0.4}),
      Setting("huberDelta", MEMBER(huberDelta), Fit, tr("Huber's δ"),
              tr("Where the Huber loss turns linear, as a fraction of the intensity range."),
              {.range = positive, .applies = [](const Settings& s) { return s.loss == LossKind::Huber; }}),
      Setting("allAxes", MEMBER(allAxes), Fit, tr("Slices of all axes"),
              tr("Fit the slices of one scan along all three of its axes."),
              {.automatic = tr("with alpha blending of nearly cubic voxels")}),
      Setting("relocate", MEMBER(relocate), Fit, tr("Relocate unused Gaussians"),
              tr("On an even grid: remove unused Gaussians and split those where the error is large.")),
      Setting("consistency", MEMBER(consistency), Fit, tr("Data-consistency step"),
              tr("After the fit, add the residual that the Gaussians leave in the scans, except noise."),
              {.part = Result}),
      Setting(
          "prediction", MEMBER(prediction), Fit, tr("Between the slices"),
          tr("What fills the gaps between distant slices: of one scan, or several that mostly lie beside "
             "each other, before Gaussians are fitted; of several that lie still, with presets balanced and "
             "best, in part. With none, the Gaussians bridge the gaps."),
          {.words = {{"auto", tr("automatic"), tr("The same as learned.")},
                     {"none", tr("nothing"), tr("The Gaussians bridge the gaps.")},
                     {"interpolation", tr("interpolation"),
                      tr("A mixture of classical interpolations, chosen by slices held out from the scan.")},
                     {"learned", tr("learned"),
                      tr("Learned from the scan's own in-plane detail; interpolation where that is no "
                         "better.")}}}),

      Setting(
          "acquiredPixels", MEMBER(acquiredPixels), Fit, tr("Pixels as acquired"),
          tr("Where a scan is noisy and its pixels look interpolated in plane (zero filling), fit the larger "
             "ones that were acquired: a better result in less time.")),
      Setting("ignorePadding", MEMBER(ignorePadding), Fit, tr("Ignore padding"),
              tr("Leave out blank slices between slices that show the body and, of several scans, what one "
                 "was filled up with, as by resampling it to another grid: one value up to its border, where "
                 "other scans show the body.")),
      Setting(
          "evenInterleaves", MEMBER(evenInterleaves), Fit, tr("Even out interleaves"),
          tr("Where every second slice is clearly brighter than those beside it, as from cross-talk between "
             "slices acquired in two passes, make odd and even slices equally bright.")),
      Setting(
          "blendEdges", MEMBER(blendEdges), Fit, tr("Blend edges"),
          tr("Several scans that still differ once aligned: blend each into the others towards its edges, "
             "where a step would remain.")),
      Setting(
          "pixelWidth", MEMBER(pixelWidth), Fit, tr("Width of pixels"),
          tr("Several scans: the width over which a pixel averages the tissue in plane, as a slice does over "
             "its thickness; 0: not at all."),
          {.range = between(0, 1000),
           .unit = tr("mm"),
           .automatic = tr("their size, where those of another scan are 1.5 times finer"),
           .usual = 1}),
      Setting("align", MEMBER(align), Fit, tr("Align the scans"),
              tr("Several scans: correct the position and the gain of each after the first to fit the "
                 "others, and say by how much.")),
      Setting("biasField", MEMBER(biasField), Fit, tr("Shading"),
              tr("Several scans: estimate each one's bias field (smooth shading, as from coils) from their "
                 "differences, and divide by it."),
              {.words = {{"off", tr("off")},
                         {"auto", tr("automatic"), tr("Where the scans agree better without it.")},
                         {"on", tr("on")}}}),
      Setting("keepBias", MEMBER(keepBias), Fit, tr("Keep the shading"),
              tr("Several scans whose bias fields are estimated: give all scans, and so the result, the bias "
                 "field of the first instead of none.")),
      Setting(
          "n4", MEMBER(n4), Fit, tr("N4 before the fit"),
          tr("Before anything else, divide each scan by the bias field that ITK's N4 finds in it alone.")),
      Setting("sliceMotion", MEMBER(sliceMotion), Fit, tr("Motion of slices"),
              tr("Several scans of thick slices: give every slice a rigid motion and a gain of its own, and "
                 "leave "
                 "out slices that fit nowhere."),
              {.words = {{"auto", tr("automatic"), tr("Where the scans agree better with it.")},
                         {"on", tr("on")},
                         {"off", tr("off")}}}),
      Setting("packets", MEMBER(packets), Fit, tr("Interleaved packets"),
              tr("Motion of slices: number of interleaved packets in which every scan was acquired (2: odd "
                 "and even slices); each packet moves as a whole."),
              {.range = between(0, 1e4), .zero = tr("every slice by itself"), .applies = movesSlices}),

      Setting("schedule", MEMBER(schedule), LearningRates, tr("Schedule"),
              tr("Learning rates decay over the iterations, or fall when the loss stops improving."),
              {.words = {{"exponential", tr("exponential")}, {"plateau", tr("plateau")}}}),
      Setting("plateauPatience", MEMBER(plateau.patience), LearningRates, tr("Patience"),
              tr("Plateau: how long without improvement before the rates fall."),
              {.range = between(1, 1e6), .unit = tr("iterations"), .applies = plateaus}),
      Setting("plateauFactor", MEMBER(plateau.factor), LearningRates, tr("Factor"),
              tr("Plateau: the factor by which the rates then fall."),
              {.range = insideUnit, .applies = plateaus}),
      Setting("plateauLowest", MEMBER(plateau.lowest), LearningRates, tr("Lowest share"),
              tr("Plateau: the rates never fall below this share of the first ones."),
              {.range = {0, 1, true}, .applies = plateaus}),
      Setting("plateauThreshold", MEMBER(plateau.threshold), LearningRates, tr("Improvement"),
              tr("Plateau: the relative fall of the loss that counts as an improvement."),
              {.range = belowOne, .applies = plateaus}),
      Setting("beta1", MEMBER(beta1), LearningRates, tr("Adam's β₁"),
              tr("Decay rate of the running mean of the gradient."), {.range = insideUnit}),
      Setting("beta2", MEMBER(beta2), LearningRates, tr("Adam's β₂"),
              tr("Decay rate of the running mean of the squared gradient."), {.range = insideUnit}),
      Setting("paperStopRule", MEMBER(paperStopRule), LearningRates, tr("Paper's stop rule"),
              tr("Stop when the loss fell by less than 1e-4 over 100 iterations, after 1000 at the latest.")),

      Setting("densifyEvery", MEMBER(densifyEvery), Densification, tr("Densify every"),
              tr("Iterations between two rounds of pruning and densification; setting a maximum number of "
                 "Gaussians turns them on."),
              {.range = between(0, 1e6), .unit = tr("iterations"), .zero = tr("never"), .usual = 10}),
      Setting("maxGaussians", MEMBER(maxGaussians), Densification, tr("Maximum Gaussians"),
              tr("Number of Gaussians that densification may reach."),
              {.range = between(1, 1e9), .automatic = tr("as many as at the start"), .usual = 100000}),
      Setting("pruneOpacity", MEMBER(densify.opacity), Densification, tr("Prune below opacity"),
              tr("Gaussians with a lower opacity are pruned; usually 0.3 with alpha blending."),
              {.range = belowOne, .applies = densifies}),
      Setting("pruneSize", MEMBER(densify.size), Densification, tr("Prune above σ"),
              tr("Gaussians with a larger standard deviation are pruned."),
              {.range = positive, .unit = tr("voxels"), .applies = densifies}),
      Setting("densifyGradient", MEMBER(densify.gradient), Densification, tr("Densify above gradient"),
              tr("A Gaussian becomes two if moving it by one voxel would lower the loss by more than that of "
                 "this many samples."),
              {.range = nonNegative, .unit = tr("samples"), .applies = densifies}),
      Setting("splitSize", MEMBER(densify.split), Densification, tr("Split above"),
              tr("Gaussians whose covariance has a larger norm are split, the others cloned."),
              {.range = nonNegative, .unit = tr("voxels²"), .applies = densifies}),

      Setting("selection", MEMBER(selection), Computation, tr("Candidates"),
              tr("Where a Gaussian is evaluated: exactly where it contributes, or by one of the paper's two "
                 "methods, to compare times (and, at cut-offs above 2.2, what method2 misses); CPU only."),
              {.words = {{"exact", tr("exact")},
                         {"method1", tr("paper's method 1")},
                         {"method2", tr("paper's method 2")}}}),
      Setting("threads", MEMBER(threads), Computation, tr("Threads"),
              tr("CPU threads to use; the result does not depend on it."),
              {.part = Speed, .range = between(0, 4096), .zero = tr("all cores"), .dynamic = true}),
      Setting("instructionSet", MEMBER(instructionSet), Computation, tr("Instruction set"),
              tr("The CPU's vector instructions to use, as listed by 'innergs info'; scalar is the plain "
                 "reference."),
              {.part = Speed, .automatic = tr("best available"), .dynamic = true}),
      Setting("seed", MEMBER(seed), Computation, tr("Seed"),
              tr("The same seed gives the same result, bit for bit, on any number of threads."),
              {.dynamic = true}),

      Setting("kind", MEMBER(kind), Dynamic, tr("What changes"),
              tr("Dynamic scans: Gaussians that move and turn, that stay and change their intensity (fMRI), "
                 "or that a deformation network changes, as in the paper."),
              {.words = {{"motion", tr("The tissue moves")},
                         {"intensity", tr("It stays and changes its intensity (fMRI)")},
                         {"network", tr("It moves, by a deformation network (slower)")}},
               .automatic = tr("motion or intensity, which predicts held-out frames better")}),
      Setting("knots", MEMBER(knots), Dynamic, tr("Knots in time"),
              tr("Dynamic scans: how many coefficients describe what changes over the whole time."),
              {.range = between(4, 4096),
               .automatic = tr("motion: those that predict held-out frames best; intensity: one per 3 "
                               "frames, more where held-out frames change faster; network: one per 2 frames"),
               .usual = 12}),
      Setting("rounds", MEMBER(rounds), Dynamic, tr("Rounds"),
              tr("Dynamic scans: passes of the joint refinement over all frames; intensities are solved for "
                 "without it."),
              {.range = between(1, 10000),
               .automatic = tr("motion: 35; network: 80; fewer for many frames"),
               .usual = 35,
               .applies = refines}),
      Setting("nodeDistance", MEMBER(nodeDistance), Dynamic, tr("Distance of motion nodes"),
              tr("Dynamic scans whose Gaussians move: distance between the nodes of the motion grid, in "
                 "voxels of the finest spacing."),
              {.range = between(1, 100),
               .unit = tr("voxels"),
               .automatic = "6",
               .usual = 6,
               .applies = mayCarry}),
      Setting("sliceTiming", MEMBER(sliceTiming), Dynamic, tr("Slice timing"),
              tr("Dynamic scans whose intensity changes: take each slice at its own time, from the NIfTI "
                 "header, BIDS file or scene, instead of the whole frame at once."),
              {.automatic = tr("true where the scan has slice times"), .applies = mayChange}),
  };
  return rows;
}

#undef MEMBER

const char* groupTitle(Setting::Group group) {
  using enum Setting::Group;
  switch (group) {
  case Basic:
    return tr("Basic");
  case Model:
    return tr("Model");
  case Fit:
    return tr("Fit");
  case LearningRates:
    return tr("Learning rates");
  case Densification:
    return tr("Densification");
  case Computation:
    return tr("Computation");
  case Dynamic:
    return tr("Dynamic scans");
  }
  return "";
}

namespace {

bool isNamedResult(const Setting& row, const Settings& settings) {
  return row.part != Setting::Part::Speed && row.isIn(settings) && row.hasEffectIn(settings);
}

/// Insertions, deletions and replacements that turn one word into another, ignoring case (Levenshtein 1966).
std::size_t distance(const std::string& a, const std::string& b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j)
    row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (lower(a[i - 1]) != lower(b[j - 1]));
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

} // namespace

const Setting& settingNamed(const std::string& name) {
  const auto& rows = settingsTable();
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row.name == name; });
  if (found != rows.end()) return *found;
  const auto nearest = std::min_element(rows.begin(), rows.end(), [&](const auto& a, const auto& b) {
    return distance(name, a.name) < distance(name, b.name);
  });
  throw Error(ErrorCode::InvalidArgument,
              "There is no setting '" + name + "': did you mean " + nearest->name + "?");
}

std::string settingsText(const Settings& settings, double heldOutFraction) {
  std::string text;
  for (const Setting& row : settingsTable())
    if (isNamedResult(row, settings)) text += row.name + ("=" + row.textIn(settings)) + "; ";
  return text + "heldOutFraction=" + exactText(heldOutFraction);
}

std::string dynamicSettingsText(const Settings& settings) {
  std::string text;
  for (const Setting& row : settingsTable())
    if (concernsDynamicScans(row) && row.name != std::string("device") && isNamedResult(row, settings))
      text += (text.empty() ? "" : "; ") + (row.name + ("=" + row.textIn(settings)));
  return text;
}

bool concernsDynamicScans(const Setting& row) {
  return row.dynamic || row.group == Setting::Group::Dynamic;
}

std::string automaticText(const Setting& row) {
  const auto shown = [&](Preset preset) {
    Settings settings;
    settings.preset = preset;
    const std::string text = row.textIn(withPresetValues(settings));
    return text == "0" && *row.zero ? std::string(row.zero) : text;
  };
  const std::string usual = shown(Preset::Balanced), paper = shown(Preset::Paper);
  if (usual.empty()) return row.automatic;
  return row.member.optional && usual != paper ? usual + "; preset paper: " + paper : usual;
}

std::string settingsMarkdown() {
  std::string text = "| setting | values | when unset | |\n|---|---|---|---|\n";
  for (const Setting& row : settingsTable()) {
    std::string values = row.words.empty() ? row.rangeText() : "";
    for (const SettingWord& word : row.words)
      values += (values.empty() ? "" : ", ") + std::string(word.name);
    if (*row.unit) values += (values.empty() ? "" : " ") + std::string(row.unit);
    if (*row.zero) values += std::string("; 0: ") + row.zero;
    text += "| `" + std::string(row.name) + "` | " + values + " | " + automaticText(row) + " | " + row.text +
            " |\n";
  }
  return text;
}

} // namespace innergs
