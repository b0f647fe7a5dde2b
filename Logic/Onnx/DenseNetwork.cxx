#include "Onnx/DenseNetwork.h"

#include "Core/Base/Error.h"
#include "Core/Base/Parallel.h"
#include "Core/Base/SystemMemory.h"
#include "Onnx/OnnxNetwork.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

using Size = std::array<std::int64_t, 3>; // I, J, K

constexpr std::int64_t kOpenVolume = 96, kOpenSlice = 512;

/// The image as the network expects it, at its spacing.
Volume prepared(const Volume& image, const DenseNetworkOptions& options, ThreadPool& pool) {
  Volume out = image;
  if (options.spacing > 0) {
    out.geometry = withSpacing(image.geometry, {options.spacing, options.spacing, options.spacing});
    out.voxels.assign(static_cast<std::size_t>(out.geometry.voxelCount()), 0.f);
    const Affine3 toImage = inverse(image.geometry.indexToWorld()) * out.geometry.indexToWorld();
    const auto [nx, ny, nz] = out.geometry.size;
    pool.run(nz, [&, nx = nx, ny = ny](std::int64_t k) {
      for (std::int64_t j = 0; j < ny; ++j)
        for (std::int64_t i = 0; i < nx; ++i)
          out.voxels[static_cast<std::size_t>(i + nx * (j + ny * k))] = sampleLinear(
              image, toImage({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}));
    });
  }
  double low = 0, scale = 1;
  if (options.range) {
    low = static_cast<double>(options.range->low);
    scale = static_cast<double>(options.range->high) - low;
    if (!(scale > 0))
      throw Error(ErrorCode::InvalidArgument,
                  "The range of intensities for the network is empty: give the lower value first.");
  } else {
    double sum = 0, square = 0;
    std::int64_t count = 0;
    for (const float value : out.voxels)
      if (std::isfinite(value)) {
        sum += static_cast<double>(value);
        square += static_cast<double>(value) * static_cast<double>(value);
        ++count;
      }
    const auto n = static_cast<double>(std::max<std::int64_t>(1, count));
    low = sum / n;
    scale = std::sqrt(std::max(0.0, square / n - low * low));
    if (!(scale > 0)) scale = 1;
  }
  for (float& value : out.voxels) {
    double scaled = std::isfinite(value) ? (static_cast<double>(value) - low) / scale : 0;
    if (options.range) scaled = std::clamp(scaled, 0.0, 1.0);
    value = static_cast<float>(scaled);
  }
  return out;
}

/// First voxels of windows that cover an axis.
std::vector<std::int64_t> startsOf(std::int64_t size, std::int64_t window, double overlap) {
  const std::int64_t last = std::max<std::int64_t>(0, size - window);
  const auto step = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::floor(static_cast<double>(window) * (1 - overlap))));
  std::vector<std::int64_t> starts;
  for (std::int64_t start = 0; start < last; start += step)
    starts.push_back(start);
  starts.push_back(last);
  return starts;
}

std::vector<float> weightsOf(std::int64_t window) {
  std::vector<float> weights;
  const double middle = 0.5 * static_cast<double>(window - 1),
               sigma = std::max(0.5, static_cast<double>(window) / 8);
  for (std::int64_t n = 0; n < window; ++n) {
    const double z = (static_cast<double>(n) - middle) / sigma;
    weights.push_back(static_cast<float>(std::max(1e-3, std::exp(-0.5 * z * z))));
  }
  return weights;
}

class SlidingWindow {
public:
  SlidingWindow(const OnnxNetwork& network, const Volume& image, const DenseNetworkOptions& options,
                ThreadPool& pool)
      : network_(network), image_(image), options_(options), pool_(pool) {
    chooseWindow();
    for (int a = 0; a < 3; ++a)
      weights_[a] = weightsOf(window_[a]);
  }

  EmbeddingVolume run() {
    std::vector<Size> starts;
    const Size& n = image_.geometry.size;
    for (const std::int64_t k : startsOf(n[2], window_[2], flat_ ? 0 : options_.overlap))
      for (const std::int64_t j : startsOf(n[1], window_[1], options_.overlap))
        for (const std::int64_t i : startsOf(n[0], window_[0], options_.overlap))
          starts.push_back({i, j, k});
    const auto total = static_cast<std::int64_t>(starts.size());
    total_.assign(static_cast<std::size_t>(image_.geometry.voxelCount()), 0.f);
    EmbeddingVolume maps{image_.geometry, {}};
    // As many windows at once as there are streams, added in their order.
    std::vector<NetworkTensor> outputs(static_cast<std::size_t>(network_.streams()));
    for (std::int64_t first = 0; first < total; first += network_.streams()) {
      const std::int64_t count = std::min<std::int64_t>(network_.streams(), total - first);
      pool_.run(count, [&](std::int64_t n) {
        outputs[static_cast<std::size_t>(n)] =
            network_.run({inputAt(starts[static_cast<std::size_t>(first + n)])}, 0, static_cast<int>(n));
      });
      for (std::int64_t n = 0; n < count; ++n)
        add(outputs[static_cast<std::size_t>(n)], starts[static_cast<std::size_t>(first + n)], maps);
      if (options_.progress)
        options_.progress(static_cast<double>(first + count) / static_cast<double>(total));
    }
    pool_.run(static_cast<std::int64_t>(maps.channels.size()), [&](std::int64_t c) {
      auto& channel = maps.channels[static_cast<std::size_t>(c)];
      for (std::size_t v = 0; v < channel.size(); ++v)
        channel[v] /= total_[v];
    });
    return maps;
  }

private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw Error(ErrorCode::InvalidArgument,
                network_.name() + " " + why +
                    ": InnerGS runs networks of one image, 1 × 1 × K × J × I or 1 "
                    "× 1 × J × I, that give channels on the same grid.");
  }

  void chooseWindow() {
    const auto& inputs = network_.inputs();
    if (inputs.size() != 1) refuse("has " + std::to_string(inputs.size()) + " inputs");
    const NetworkPort& in = inputs[0];
    if (in.type != NetworkPort::Type::Float) refuse("takes no floating-point image");
    if (in.anyRank || (in.shape.size() != 4 && in.shape.size() != 5))
      refuse("takes an input of " + (in.anyRank ? "any number of" : std::to_string(in.shape.size())) +
             " axes");
    if (in.shape[0] > 1 || in.shape[1] > 1) refuse("takes several images or channels at once");
    flat_ = in.shape.size() == 4;
    window_[2] = 1;
    const int axes = flat_ ? 2 : 3;
    for (int a = 0; a < axes; ++a) {
      const std::int64_t fixed = in.shape[in.shape.size() - 1 - static_cast<std::size_t>(a)],
                         open = options_.window[static_cast<std::size_t>(a)] > 0
                                    ? options_.window[static_cast<std::size_t>(a)]
                                    : (flat_ ? kOpenSlice : kOpenVolume);
      window_[static_cast<std::size_t>(a)] = fixed > 0 ? fixed : open;
    }
  }

  std::vector<std::int64_t> shape() const {
    if (flat_) return {1, 1, window_[1], window_[0]};
    return {1, 1, window_[2], window_[1], window_[0]};
  }

  /// The image's nearest voxel where the window reaches beyond it.
  NetworkTensor inputAt(const Size& start) const {
    const Size& n = image_.geometry.size;
    std::vector<float> values(static_cast<std::size_t>(window_[0] * window_[1] * window_[2]));
    auto at = values.begin();
    for (std::int64_t k = 0; k < window_[2]; ++k)
      for (std::int64_t j = 0; j < window_[1]; ++j) {
        const float* row = image_.voxels.data() + n[0] * (std::min(start[1] + j, n[1] - 1) +
                                                          n[1] * std::min(start[2] + k, n[2] - 1));
        for (std::int64_t i = 0; i < window_[0]; ++i)
          *at++ = row[std::min(start[0] + i, n[0] - 1)];
      }
    return {shape(), std::move(values)};
  }

  /// How many voxels of the window share a value of the output, along each axis.
  Size coarsenessOf(const NetworkTensor& out) const {
    const std::size_t axes = flat_ ? 2 : 3;
    if (out.shape.size() != axes + 2 || out.shape[0] != 1 || out.shape[1] < 1)
      refuse("gives an output of " + std::to_string(out.shape.size()) + " axes or of several images");
    Size coarseness{1, 1, 1};
    for (std::size_t a = 0; a < axes; ++a) {
      const std::int64_t size = out.shape[out.shape.size() - 1 - a];
      if (size < 1 || window_[a] % size != 0)
        refuse("turns " + std::to_string(window_[a]) + " voxels into " + std::to_string(size));
      coarseness[a] = window_[a] / size;
    }
    return coarseness;
  }

  void add(const NetworkTensor& out, const Size& start, EmbeddingVolume& maps) {
    const Size coarseness = coarsenessOf(out);
    const std::int64_t channels = out.shape[1];
    if (maps.channels.empty()) allocate(channels, maps);
    if (channels != static_cast<std::int64_t>(maps.channels.size()))
      refuse("gives another number of channels each time");
    const auto& values = std::get<std::vector<float>>(out.values);
    const Size& n = image_.geometry.size;
    Size covered{}, cells{};
    for (std::size_t a = 0; a < 3; ++a) {
      covered[a] = std::min(window_[a], n[a] - start[a]);
      cells[a] = window_[a] / coarseness[a];
    }
    const auto forVoxels = [&](auto&& each) { // each(voxel of the image, cell of the output, weight)
      for (std::int64_t k = 0; k < covered[2]; ++k)
        for (std::int64_t j = 0; j < covered[1]; ++j) {
          const std::int64_t row = start[0] + n[0] * (start[1] + j + n[1] * (start[2] + k)),
                             cell = cells[0] * (j / coarseness[1] + cells[1] * (k / coarseness[2]));
          const float weight =
              weights_[1][static_cast<std::size_t>(j)] * weights_[2][static_cast<std::size_t>(k)];
          for (std::int64_t i = 0; i < covered[0]; ++i)
            each(static_cast<std::size_t>(row + i), static_cast<std::size_t>(cell + i / coarseness[0]),
                 weight * weights_[0][static_cast<std::size_t>(i)]);
        }
    };
    forVoxels([&](std::size_t voxel, std::size_t, float weight) { total_[voxel] += weight; });
    const auto stride = static_cast<std::size_t>(cells[0] * cells[1] * cells[2]);
    pool_.run(channels, [&](std::int64_t c) {
      const float* from = values.data() + static_cast<std::size_t>(c) * stride;
      auto& into = maps.channels[static_cast<std::size_t>(c)];
      forVoxels(
          [&](std::size_t voxel, std::size_t cell, float weight) { into[voxel] += weight * from[cell]; });
    });
  }

  void allocate(std::int64_t channels, EmbeddingVolume& maps) const {
    const std::int64_t voxels = image_.geometry.voxelCount(), available = availableMemory();
    if (available > 0 && channels > available / (4 * voxels))
      throw Error(ErrorCode::Memory, "The " + std::to_string(channels) + " channels of " + network_.name() +
                                         " do not fit into memory: choose a coarser spacing.");
    maps.channels.assign(static_cast<std::size_t>(channels),
                         std::vector<float>(static_cast<std::size_t>(voxels), 0.f));
  }

  const OnnxNetwork& network_;
  const Volume& image_;
  const DenseNetworkOptions& options_;
  ThreadPool& pool_;
  bool flat_ = false; // slice by slice
  Size window_{1, 1, 1};
  std::array<std::vector<float>, 3> weights_;
  std::vector<float> total_; // sum of the weights per voxel
};

} // namespace

EmbeddingVolume applyNetwork(const std::filesystem::path& file, const Volume& image,
                             const DenseNetworkOptions& options) {
  checkGeometry(image.geometry, "The image");
  if (!(options.overlap >= 0 && options.overlap <= 0.9))
    throw Error(ErrorCode::InvalidArgument, "The overlap of windows must be between 0 and 0.9.");
  if (!(options.spacing >= 0))
    throw Error(ErrorCode::InvalidArgument, "The spacing must be above 0 mm, or 0.");
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const OnnxNetwork network(file, pool.threads());
  const Volume scaled = prepared(image, options, pool);
  return SlidingWindow(network, scaled, options, pool).run();
}

Labelmap likeliestChannel(const EmbeddingVolume& maps) {
  if (maps.channels.size() < 2 || maps.channels.size() > 65536)
    throw Error(ErrorCode::InvalidArgument,
                "A network that segments gives a channel for the background and one for every segment.");
  Labelmap labels{maps.geometry, std::vector<std::uint16_t>(maps.channels[0].size(), 0), {}};
  std::vector<float> greatest = maps.channels[0];
  for (std::size_t c = 1; c < maps.channels.size(); ++c)
    for (std::size_t v = 0; v < greatest.size(); ++v)
      if (maps.channels[c][v] > greatest[v]) {
        greatest[v] = maps.channels[c][v];
        labels.voxels[v] = static_cast<std::uint16_t>(c);
      }
  return labels;
}

Teacher networkTeacher(const std::filesystem::path& file, const Volume& image,
                       const std::vector<SegmentName>& names, const std::vector<TextEmbedding>& texts,
                       const DenseNetworkOptions& options) {
  if (names.empty() == texts.empty())
    throw Error(ErrorCode::InvalidArgument, "A network teaches segments or features: give the names of its "
                                            "channels or, for features, text embeddings.");
  EmbeddingVolume maps = applyNetwork(file, image, options);
  if (!texts.empty()) return DenseTeacher{std::move(maps), texts};
  for (const SegmentName& name : names)
    if (name.label >= maps.channels.size())
      throw Error(ErrorCode::InvalidArgument, "The network gives " + std::to_string(maps.channels.size()) +
                                                  " channels, but \"" + name.name + "\" should be channel " +
                                                  std::to_string(name.label) +
                                                  ": channel 0 is the background, 1 the first segment.");
  return NamedLabels{likeliestChannel(maps), names};
}

} // namespace innergs
