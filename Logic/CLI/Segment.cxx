#include "CLI/Command.h"
#include "CLI/Interrupt.h"
#include "CLI/Options.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Device/FeatureDeviceChoice.h"
#include "Core/Features/Teacher.h"
#include "Core/Motion/DynamicFeatures.h"
#include "Core/Motion/MotionField.h"
#include "Core/Render/Render.h"
#include "IO/BidsSidecar.h"
#include "IO/DynamicModelFile.h"
#include "IO/EmbeddingIO.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/OutputFiles.h"
#include "IO/SegmentNames.h"
#include "IO/TextEmbeddingIO.h"
#include "IO/TimeSeriesWriting.h"
#include "Onnx/DenseNetwork.h"
#include "Text/SegmentFinder.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace innergs::cli {
namespace {

struct SegmentCommand {
  std::string model, labels, names, features, texts, output, score, saveModel, textModel, network, image;
  std::vector<float> networkRange;
  double networkSpacing = 0;
  std::optional<double> time, labelTime;
  std::vector<std::string> queries;
  GridOptions grid;
  FeatureTraining training;
  Settings settings; // threads, device
  SegmentOptions segment;
  bool sparse = false, quiet = false;
};

std::vector<SegmentName> namesFor(const SegmentCommand& o, const std::string& otherwise) {
  std::vector<SegmentName> names = readSegmentNames(o.names.empty() ? otherwise : o.names);
  if (names.empty())
    throw Error(
        ErrorCode::InvalidArgument,
        "The segments of " + innergs::quoted(o.names.empty() ? otherwise : o.names) +
            " have no names: give a file with them as --names, e.g. {\"1\": \"liver\", \"2\": \"spleen\"}.");
  return names;
}

void remarkOnEmptySlices(const SegmentCommand& o, const Labelmap& labels) {
  const Labelmap sparse = withSparseSlices(labels);
  const auto empty = std::count(sparse.labelled.begin(), sparse.labelled.end(), 0);
  if (2 * empty > static_cast<std::int64_t>(sparse.labelled.size()))
    fmt::print(
        stderr,
        "innergs: {} of {} slices of {} hold no label and count as background; give --sparse if nobody "
        "labelled them.\n",
        empty, sparse.labelled.size(), innergs::quoted(o.labels));
}

std::function<void(double)> learningDisplay(const char* what) {
  return [what, shown = 0](double fraction) mutable {
    const int percent = static_cast<int>(100 * fraction);
    if (percent < shown + 10) return;
    shown = percent - percent % 10;
    fmt::print(stderr, "{} {} %\n", what, shown);
  };
}

NamedLabels givenLabels(const SegmentCommand& o) {
  NamedLabels given{{}, namesFor(o, o.labels)};
  given.labels = labelmapOf(readVolume(o.labels));
  if (o.sparse)
    given.labels = withSparseSlices(given.labels);
  else if (!o.quiet)
    remarkOnEmptySlices(o, given.labels);
  return given;
}

/// The teacher from a network's output for --image or, without one, for the model on the grid that was
/// fitted.
Teacher networksView(const SegmentCommand& o, const GaussianField& field, const std::stop_token& stop) {
  DenseNetworkOptions options;
  options.spacing = o.networkSpacing;
  if (!o.networkRange.empty()) options.range = ValueRange{o.networkRange[0], o.networkRange[1]};
  options.threads = o.settings.threads;
  options.stop = stop;
  if (!o.quiet) options.progress = learningDisplay("Running the network");
  const std::vector<SegmentName> names = o.texts.empty() ? namesFor(o, {}) : std::vector<SegmentName>();
  const std::vector<TextEmbedding> texts =
      o.texts.empty() ? std::vector<TextEmbedding>() : readTextEmbeddings(o.texts);
  RenderOptions rendering;
  rendering.threads = o.settings.threads;
  rendering.stop = stop;
  return networkTeacher(o.network,
                        o.image.empty() ? render(field, field.region(), rendering) : readVolume(o.image),
                        names, texts, options);
}

DenseTeacher givenFeatures(const SegmentCommand& o) {
  // Not a braced list: if its second reading throws, GCC 12 destroys members that it never built.
  DenseTeacher teacher;
  teacher.features = readEmbeddingVolume(o.features);
  teacher.texts = readTextEmbeddings(o.texts);
  return teacher;
}

FeatureModel learn(const SegmentCommand& o, const GaussianField& field, const Interrupt& interrupt) {
  const Teacher teacher = !o.network.empty()  ? networksView(o, field, interrupt.token())
                          : !o.labels.empty() ? Teacher(givenLabels(o))
                                              : Teacher(givenFeatures(o));
  FeatureTraining training = o.training;
  training.threads = o.settings.threads;
  training.stop = interrupt.token();
  const auto devices = std::make_shared<FeatureDeviceChoice>(o.settings.device);
  training.devices = devices;
  if (!o.quiet) training.progress = learningDisplay("Learning features");
  FeatureModel model = trainFrom(field, teacher, training);
  if (!o.quiet && (devices->use().id != "cpu" || o.settings.device != "auto"))
    fmt::print(stderr, "{}\n", devices->use().reason);
  return model;
}

/// The segments that the queries ask for; tells how each was understood. Throws if there is none.
std::vector<RequestedSegment> answer(const SegmentCommand& o, const SegmentFinder& finder, bool tell) {
  std::vector<RequestedSegment> wanted;
  std::string last;
  for (const std::string& query : o.queries) {
    const SegmentAnswer found = finder.find(query);
    last = found.sentence;
    const auto requested = finder.requested(query, found);
    if (tell && (!requested.empty() || o.queries.size() > 1)) fmt::print(stderr, "{}\n", found.sentence);
    wanted.insert(wanted.end(), requested.begin(), requested.end());
  }
  if (wanted.empty())
    throw Error(ErrorCode::NoData,
                o.queries.size() == 1 ? last : "None of the queries names a segment of this model.");
  return wanted;
}

SegmentInfo infoOf(const SegmentTerms& terms, std::uint16_t label) {
  SegmentInfo info;
  info.name = {label, terms.name};
  info.color = terms.color;
  info.terminology = terminologyEntry(terms);
  return info;
}

void checkUsage(const SegmentCommand& o) {
  if (o.output.empty() && o.saveModel.empty() && o.queries.empty())
    throw CLI::ValidationError("segment", "needs --query with --output, or --save-model");
  if (!o.output.empty() && o.queries.empty())
    throw CLI::ValidationError("segment", "--output needs a --query");
  if (!o.score.empty() && o.queries.size() != 1)
    throw CLI::ValidationError("segment", "--score is for a single --query");
  if (o.labels.empty() && o.sparse) throw CLI::ValidationError("segment", "--sparse goes with --labels");
  if (o.labels.empty() && o.network.empty() && !o.names.empty())
    throw CLI::ValidationError("segment", "--names goes with --labels or --network");
  if (o.features.empty() && o.network.empty() && !o.texts.empty())
    throw CLI::ValidationError("segment", "--text-embeddings goes with --features or --network");
  if (!o.network.empty() && o.names.empty() == o.texts.empty())
    throw CLI::ValidationError("segment", "--network needs --names or --text-embeddings");
  if (!o.network.empty() && !o.labels.empty())
    throw CLI::ValidationError("segment", "--labels excludes --network");
  if (o.labels.empty() && o.features.empty() && o.network.empty() && !o.saveModel.empty())
    throw CLI::ValidationError("segment", "--save-model goes with --labels, --features or --network");
}

bool learns(const SegmentCommand& o) {
  return !o.labels.empty() || !o.features.empty() || !o.network.empty();
}

[[noreturn]] void refuseWithoutFeatures(const SegmentCommand& o) {
  throw Error(
      ErrorCode::NoData,
      innergs::quoted(o.model) +
          " has no features yet: give labels to learn from as --labels, or a feature volume as --features.");
}

/// Segments of one grid in an image, and how they are scored.
struct FoundSegments {
  Volume labels, score;             // of several segments, the likeliest's score
  std::vector<SegmentInfo> infos;   // per segment; label n + 1
  std::vector<std::int64_t> voxels; // likewise
};

FoundSegments foundOn(const GridGeometry& grid, const SegmentFinder& finder,
                      const std::vector<RequestedSegment>& wanted, const SegmentCommand& o,
                      const std::stop_token& stop) {
  FoundSegments found{
      {grid, std::vector<float>(static_cast<std::size_t>(grid.voxelCount()), 0.f)}, {grid, {}}, {}, {}};
  if (!o.score.empty()) found.score.voxels.resize(found.labels.voxels.size(), 0.f);
  for (std::size_t n = 0; n < wanted.size(); ++n) {
    const Segment segment = finder.probabilities()->segment(wanted[n].classes, o.segment, stop);
    forEachVoxel(segment, grid.size, [&](std::size_t voxel, std::size_t at) {
      if (segment.mask[at]) found.labels.voxels[voxel] = static_cast<float>(n + 1);
      if (!found.score.voxels.empty())
        found.score.voxels[voxel] = std::max(found.score.voxels[voxel], segment.probability[at]);
    });
    found.infos.push_back(infoOf(wanted[n].terms, static_cast<std::uint16_t>(n + 1)));
    found.voxels.push_back(segment.voxels);
  }
  return found;
}

void tell(const FoundSegments& found, const std::string& when = {}) {
  const GridGeometry& grid = found.labels.geometry;
  const Vec3& mm = grid.spacing;
  for (std::size_t n = 0; n < found.infos.size(); ++n)
    fmt::print(stderr, "{}{}: label {}, {} voxels, {:.1f} ml\n", when, found.infos[n].name.name, n + 1,
               found.voxels[n], static_cast<double>(found.voxels[n]) * mm[0] * mm[1] * mm[2] / 1000);
}

OutputType typeFor(const std::vector<RequestedSegment>& wanted) {
  return wanted.size() > 255 ? OutputType::UInt16 : OutputType::UInt8;
}

void write(const FoundSegments& found, OutputType type, const SegmentCommand& o, OutputFiles& files) {
  files.write(o.output, [&](const auto& path) {
    writeVolume(found.labels, path, type, {},
                fullExtension(path) == ".nrrd" ? segmentFields(found.infos, found.labels.geometry)
                                               : std::map<std::string, std::string>{});
  });
  files.write(o.score, [&](const auto& path) { writeVolume(found.score, path); });
}

FeatureQueryOptions queryOptions(const SegmentCommand& o, const Interrupt& interrupt) {
  FeatureQueryOptions query;
  query.threads = o.settings.threads;
  query.stop = interrupt.token();
  return query;
}

void segmentStatic(const SegmentCommand& o, const Interrupt& interrupt, OutputFiles& files) {
  if (o.time || o.labelTime)
    throw CLI::ValidationError("segment", "--time and --label-time are for a model of a dynamic scan");
  ModelNotes notes;
  std::optional<FeatureModel> features;
  const Model model = readModel(o.model, &notes, &features);
  const GaussianField& field = model.field;
  if (learns(o)) features = learn(o, field, interrupt);
  if (!features) refuseWithoutFeatures(o);
  files.write(o.saveModel, [&](const auto& path) { writeModel(model, path, notes, &*features); });
  if (o.queries.empty()) return;
  SegmentFinder finder({{std::shared_ptr<const Model>(), &field},
                        std::make_shared<const FeatureModel>(std::move(*features)),
                        {}});
  const GridGeometry grid = o.grid.choose(field.region(), field.region());
  checkMemory(grid.voxelCount() * 16, "The labelmap");
  answer(o, finder, false); // a query that asks for nothing ends here, not after the grid was decoded
  finder.encode(grid, queryOptions(o, interrupt));
  const std::vector<RequestedSegment> wanted = answer(o, finder, true);
  const FoundSegments found = foundOn(grid, finder, wanted, o, interrupt.token());
  if (!o.quiet) tell(found);
  write(found, typeFor(wanted), o, files);
}

/// Every frame of a dynamic scan, or one time.
void segmentDynamic(const SegmentCommand& o, const Interrupt& interrupt, OutputFiles& files) {
  if (!o.time && !o.score.empty())
    throw CLI::ValidationError("segment", "--score of a dynamic scan's model needs --time");
  if (!o.time && !o.output.empty()) checkTimeSeriesPath(o.output);
  ModelNotes notes;
  RefinementState state;
  std::optional<FeatureModel> features;
  const DynamicField field = readDynamicModel(o.model, &notes, &state, &features);
  const std::vector<double> times = o.time ? checkedTimes({*o.time}, field.times) : field.times;
  if (learns(o)) {
    const double time = checkedTimes({o.labelTime.value_or(middleTime(field))}, field.times).front();
    features = learn(o, featureFieldAt(field, time), interrupt);
    features->time = time;
  }
  if (!features) refuseWithoutFeatures(o);
  files.write(o.saveModel,
              [&](const auto& path) { writeDynamicModel(field, path, notes, state, &*features); });
  if (o.queries.empty()) return;
  const auto shared = std::make_shared<const FeatureModel>(std::move(*features));
  const GridGeometry grid = o.grid.choose(field.canonical.region(), field.canonical.region());
  checkMemory(grid.voxelCount() * (16 + 4 * static_cast<std::int64_t>(times.size())), "The labelmaps");
  const auto finderAt = [&](double time) {
    return SegmentFinder({{}, shared, {std::shared_ptr<const DynamicField>(), &field}, time});
  };
  const std::vector<RequestedSegment> wanted = answer(o, finderAt(times.front()), true);
  if (!o.output.empty() && !o.time && needsSidecar(o.output, times)) files.add(sidecarOf(o.output));
  TimeSeries series{grid, {}, times, {}, {}};
  for (const double time : times) {
    SegmentFinder finder = finderAt(time);
    finder.encode(grid, queryOptions(o, interrupt));
    FoundSegments found = foundOn(grid, finder, wanted, o, interrupt.token());
    if (!o.quiet) tell(found, numberText(time) + " s, ");
    if (o.time) return write(found, typeFor(wanted), o, files);
    series.frames.push_back(std::move(found.labels.voxels));
  }
  files.write(o.output, [&](const auto& path) { writeTimeSeries(series, path, typeFor(wanted)); });
}

int segment(const SegmentCommand& o) {
  checkUsage(o);
  OutputFiles files;
  for (const std::string& input :
       {o.model, o.labels, o.names, o.features, o.texts, o.network, o.image, o.grid.reference})
    files.read(input);
  const bool dynamic = isDynamicModel(o.model);
  files.add(o.output, dynamic && !o.time ? OutputFiles::Kind::Any : OutputFiles::Kind::Volume);
  files.add(o.score, OutputFiles::Kind::Volume);
  files.add(o.saveModel, OutputFiles::Kind::Model);
  for (const std::string& query : o.queries)
    interpret(Lexicon::standard(), query); // rejects invalid queries before the work starts
  if (!o.textModel.empty()) useTextModel(o.textModel);
  Interrupt interrupt;
  if (dynamic)
    segmentDynamic(o, interrupt, files);
  else
    segmentStatic(o, interrupt, files);
  files.check();
  if (!o.quiet && !files.written().empty()) fmt::print(stderr, "Wrote {}.\n", files.written());
  return Success;
}

} // namespace

Subcommand addSegment(CLI::App& app) {
  auto* command = app.add_subcommand("segment", "Finds segments of a model by name");
  auto o = std::make_shared<SegmentCommand>();
  addOption(*command, "model", o->model, "MODEL", "Model (.innergs)")->required();
  auto* labels = addOption(*command, "--labels", o->labels, "IMAGE",
                           "Labelmap or segmentation (.seg.nrrd) to learn from, on any grid; not "
                           "needed for a model saved with features");
  addOption(*command, "--names", o->names, "FILE",
            "Names of the labels, or of a network's channels: JSON, {\"1\": \"liver\", \"2\": "
            "\"spleen\"}, or a\n"
            ".seg.nrrd [those in the labels' own header]");
  auto* features =
      addOption(*command, "--features", o->features, "IMAGE",
                "Feature volume to learn from instead, as a vision-language model gives it: several\n"
                "values per voxel (.nii.gz, .nrrd, .mha)")
          ->excludes(labels);
  auto* texts = addOption(*command, "--text-embeddings", o->texts, "FILE",
                          "Embeddings of texts by that model: JSON, {\"liver\": [0.1, ...], "
                          "\"background\": [...]}");
  features->needs(texts);
  auto* network =
      addOption(*command, "--network", o->network, "FILE",
                "Network to learn from instead (ONNX, run by OpenVINO): takes an image, gives a channel "
                "for\nthe background and one per segment (--names), or features (--text-embeddings)")
          ->excludes(features);
  addOption(*command, "--image", o->image, "IMAGE", "Image that the network is shown [the model's own]")
      ->needs(network);
  addOption(*command, "--network-range", o->networkRange, "LOW HIGH",
            "Intensities that become 0 and 1 for the network [mean 0, standard deviation 1]")
      ->expected(2)
      ->needs(network);
  addOption(*command, "--network-spacing", o->networkSpacing, "MM",
            "Voxels that the network expects, mm [the image's own]")
      ->check(CLI::PositiveNumber)
      ->needs(network);
  command->add_flag("--sparse", o->sparse,
                    "Unlabelled slices between labelled ones follow the image instead of being background");
  addOption(*command, "--query", o->queries, "TEXT",
            "A structure in words, e.g. \"left kidney\"; repeat for more segments")
      ->allow_extra_args(false);
  addTextModel(*command, o->textModel);
  addOption(*command, "-o,--output", o->output, "FILE",
            "Labelmap to write: .nii, .nii.gz, .mha or, with names, .seg.nrrd");
  addOption(*command, "--score", o->score, "FILE",
            "Volume to write: the probability of the query at each voxel");
  addOption(*command, "--save-model", o->saveModel, "FILE",
            "Model to write, with what was learned (.innergs)");
  addOption(*command, "--threshold", o->segment.threshold, "P",
            "Voxels with at least this probability [where it is the likeliest]")
      ->check(CLI::Range(0.01, 1.0));
  addOption(*command, "--smooth", o->segment.smoothing, "MM",
            "Smooth the segments with a Gaussian of this standard deviation in mm [0]")
      ->check(CLI::Range(0.0, 100.0));
  command->add_flag("--largest", o->segment.largestOnly, "Only the largest connected part of each segment");
  addOption(*command, "--minimum-size", o->segment.minimumSize, "MM3",
            "Smallest volume of a connected part, mm3 [0]")
      ->check(CLI::NonNegativeNumber);
  addOption(*command, "--time", o->time, "S",
            "Time in s of a dynamic scan's model [every frame, as a 4D labelmap: .nii, .nii.gz, "
            ".seq.nrrd]");
  addOption(*command, "--label-time", o->labelTime, "S",
            "Time in s of a dynamic scan that --labels belong to [the middle frame's]");
  o->grid.add(*command, "the grid that was fitted");
  addOption(*command, "--channels", o->training.channels, "N",
            "Channels of a latent: 8 (with --labels), 16 or 32 [16]")
      ->check(CLI::IsMember({8, 16, 32}));
  addSetting(*command, o->settings, "threads");
  addSetting(*command, o->settings, "device");
  command->add_flag("-q,--quiet", o->quiet, "Print only what was found");
  command->footer(
      "Research software: the segments are only as good as the labels, and no diagnosis.\n"
      "Examples:\n"
      "  innergs segment ct.innergs --labels organs.seg.nrrd --query liver -o liver.seg.nrrd\n"
      "  innergs segment ct.innergs --labels every5th.nii.gz --names names.json --sparse --save-model "
      "named.innergs\n"
      "  innergs segment named.innergs --query \"left kidney\" --query ribs -o found.nii.gz\n"
      "  innergs segment wrist.innergs --labels frame0.seg.nrrd --label-time 0 --query lunate -o "
      "lunate.nii.gz");
  return {command, [o] { return segment(*o); }};
}

} // namespace innergs::cli
