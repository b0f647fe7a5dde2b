// A device plugin whose devices are the CPU in disguise. The environment variable INNERGS_FAKE selects the
// failure: none, small, short (after three iterations), throws, make, upload, iteration:N, lost:N, reshape,
// evaluate, gradient:N, download, render, mark (renders values that are 1 too high), later (likewise, but not
// during the initial self-check).
#include "Core/Base/Error.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Fit/CpuFitDevice.h"
#include "Core/Render/GridRenderer.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/RenderPoints.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace {

using namespace innergs;

bool fault(const std::string& name, int* number = nullptr) {
  const char* set = std::getenv("INNERGS_FAKE");
  const std::string text = set ? set : "";
  if (text.substr(0, text.find(':')) != name) return false;
  if (number) *number = std::stoi(text.substr(text.find(':') + 1));
  return true;
}

[[noreturn]] void outOfMemory() {
  throw Error(ErrorCode::Memory, "The device has no memory left.");
}

class FakeFit : public FitDevice {
public:
  explicit FakeFit(const FitRequest& request) : pool_(2), inner_(request, kernelSet("scalar"), pool_) {
    pool_.setStop(request.stop);
  }
  void upload(const GaussianField& field, const Adam& adam, const GradientAccumulator& accumulator) override {
    if (fault("upload")) outOfMemory();
    inner_.upload(field, adam, accumulator);
  }
  void download(GaussianField* field, Adam* adam, GradientAccumulator* accumulator) override {
    if (lost_ || fault("download")) throw std::runtime_error("The device fell off the bus.");
    inner_.download(field, adam, accumulator);
  }
  LossSum iterate(const IterationOptions& options) override {
    int at = 0;
    ++iterations_;
    if (fault("iteration", &at) && iterations_ == at) outOfMemory();
    if (fault("lost", &at) && iterations_ == at) {
      lost_ = true;
      throw Error(ErrorCode::Internal, "The device fell off the bus.");
    }
    return inner_.iterate(options);
  }
  DensifyCounts densify() override {
    if (fault("reshape")) outOfMemory();
    return inner_.densify();
  }
  LossSum evaluate(const GaussianField& field) override {
    if (fault("evaluate")) outOfMemory();
    return inner_.evaluate(field);
  }
  LossSum gradient(const GaussianField& field, std::int64_t observation, std::span<float> gradient) override {
    int at = 0;
    ++gradients_;
    if (fault("gradient", &at) && gradients_ == at) outOfMemory();
    return inner_.gradient(field, observation, gradient);
  }

  std::string remark() const override {
    return fault("short") && iterations_ > 3 ? "Its memory is short: the slices are processed in 7 parts."
                                             : "";
  }

private:
  ThreadPool pool_;
  CpuFitDevice inner_;
  int iterations_ = 0, gradients_ = 0;
  bool lost_ = false;
};

class FakeField : public FieldDevice {
public:
  explicit FakeField(const GaussianField& field) : field_(field) {
    field_.residual = {};
    field_.domain = {};
  }
  void renderGrid(const SampleGrid& grid, const ClosedFormPsf& psf, std::span<const float> values, float* out,
                  std::stop_token stop) override {
    if (fault("render")) outOfMemory();
    ThreadPool pool(2);
    pool.setStop(std::move(stop));
    GridRenderer renderer(grid, kernelSet("scalar"), pool, psf);
    std::vector<float> w(grid.bufferSize()), n(w.size());
    renderer.forward(field_, values, w.data(), n.data());
    for (std::size_t row = 0; row < static_cast<std::size_t>(grid.ny) * grid.z.size(); ++row)
      for (int x = 0; x < grid.nx; ++x) {
        const std::size_t at = row * grid.stride() + x;
        *out++ = shift() + (field_.blending == Blending::Normalised
                                ? n[at] / (w[at] + static_cast<float>(field_.epsilon))
                                : n[at]);
      }
  }
  void renderPoints(std::span<const Vec3> points, std::span<const float> values, float* out,
                    std::stop_token stop) override {
    if (fault("render")) outOfMemory();
    GaussianField field = field_;
    field.modelToWorld = {};
    RenderOptions options;
    options.scannerUnits = false;
    options.bounded = false;
    options.values = values;
    options.stop = std::move(stop);
    for (float value : innergs::renderPoints(field, points, options))
      *out++ = value + shift();
  }

private:
  float shift() const { return fault("mark") || (fault("later") && number_ > 3) ? 1.f : 0.f; }
  static inline int fields_ = 0; // a self-check makes three
  const int number_ = ++fields_;
  GaussianField field_;
};

class FakePlugin : public DevicePlugin {
public:
  FakePlugin() {
#ifdef INNERGS_FAKE_REFUSES
    throw std::runtime_error("it does not like to");
#endif
  }
  DeviceList devices() override {
    DeviceList list;
    if (fault("throws")) throw std::runtime_error("nothing answers");
    if (fault("none")) {
      list.problem = "No NVIDIA driver is installed.";
      return list;
    }
    list.devices.push_back({"Fake One", "7.5", 8'000'000'000, 0, {}});
    list.devices.push_back({"Fake Two", "9.0", 16'000'000'000, 0, {}});
    return list;
  }
  std::int64_t freeMemory(int device) override {
    return (fault("small") ? 1000 : 4'000'000'000) / (device == 0 ? 2 : 1);
  }
  std::int64_t fitMemory(const FitRequest& request) override {
    std::int64_t bytes = request.gaussians * 512;
    for (const Observation& o : *request.observations)
      bytes += static_cast<std::int64_t>(5 * o.target.size());
    return bytes;
  }
  std::unique_ptr<FitDevice> makeFit(int, const FitRequest& request) override {
    if (fault("make")) outOfMemory();
    return std::make_unique<FakeFit>(request);
  }
  std::unique_ptr<FieldDevice> makeField(int, const GaussianField& field) override {
    return std::make_unique<FakeField>(field);
  }
  std::unique_ptr<FeatureDevice> makeFeatures(int, const FeatureProblem&) override {
    throw Error(ErrorCode::Memory, "it learns no features.");
  }
};

} // namespace

INNERGS_DEVICE_PLUGIN(FakePlugin)
