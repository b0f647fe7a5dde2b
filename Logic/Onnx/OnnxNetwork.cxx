#include "Onnx/OnnxNetwork.h"

#include "Core/Base/Error.h"
#include "Core/Base/PathText.h"
#include "Onnx/OpenVino.h"
#include "Onnx/OpenVinoFunctions.h"

#include <algorithm>
#include <fstream>
#include <utility>

namespace innergs {
namespace {

using Api = OpenVinoFunctions;

/// An object of OpenVINO, freed with its own function.
template <class T, class Free>
class Owned {
public:
  explicit Owned(Free free) : free_(free) {}
  Owned(Owned&& other) noexcept : free_(other.free_), object_(std::exchange(other.object_, nullptr)) {}
  Owned& operator=(Owned&&) = delete;
  ~Owned() {
    if (object_) free_(object_);
  }
  T** out() { return &object_; }
  T* get() const { return object_; }

private:
  Free free_;
  T* object_ = nullptr;
};
template <class T, class Free>
Owned<T, Free> owned(Free free) {
  return Owned<T, Free>(free);
}

std::size_t countOf(const std::vector<std::int64_t>& shape) {
  std::size_t count = 1;
  for (const std::int64_t size : shape)
    count *= static_cast<std::size_t>(std::max<std::int64_t>(size, 0));
  return count;
}

NetworkPort::Type typeOf(Api::Type type) {
  if (type == Api::Float32) return NetworkPort::Type::Float;
  return type == Api::Int32 || type == Api::Int64 ? NetworkPort::Type::Integer : NetworkPort::Type::Other;
}

/// OpenVINO tries its readers of other formats on any file, and these print their complaints to stderr; an
/// ONNX file begins with its version.
bool mayBeOnnx(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return in.get() == 0x08;
}

template <class To, class From>
void copyAs(const std::vector<From>& from, void* to) {
  std::transform(from.begin(), from.end(), static_cast<To*>(to),
                 [](From value) { return static_cast<To>(value); });
}

} // namespace

struct OnnxNetwork::Internals {
  using RequestOwner = Owned<Api::Request, decltype(Api::infer_request_free)>;

  explicit Internals(const Api& functions)
      : api(functions), core(functions.core_free), compiled(functions.compiled_model_free) {}

  const Api& api;
  std::string name;
  Owned<Api::Core, decltype(Api::core_free)> core;
  Owned<Api::CompiledModel, decltype(Api::compiled_model_free)> compiled;
  std::vector<RequestOwner> requests; // per stream
  std::vector<NetworkPort> inputs, outputs;
  std::vector<Api::Type> inputTypes;

  [[noreturn]] void fail(const std::string& what) const { throw Error(ErrorCode::FileFormat, name + what); }
  void check(Api::Status status) const {
    if (status != 0) fail(" does not run in OpenVINO: give another network.");
  }

  NetworkPort portOf(const Api::Port* port, Api::Type& type) const {
    NetworkPort out;
    char* text = nullptr;
    if (api.port_get_any_name(port, &text) == 0 && text) { // an output may have none
      out.name = text;
      api.free(text);
    }
    check(api.port_get_element_type(port, &type));
    out.type = typeOf(type);
    Api::PartialShape shape{};
    check(api.port_get_partial_shape(port, &shape));
    out.anyRank = shape.rank.least != shape.rank.most;
    for (std::int64_t a = 0; !out.anyRank && a < shape.rank.least; ++a)
      out.shape.push_back(shape.sizes[a].least == shape.sizes[a].most ? shape.sizes[a].least : -1);
    api.partial_shape_free(&shape);
    return out;
  }

  void readPorts() {
    std::size_t count = 0;
    Api::Type type{};
    check(api.compiled_model_inputs_size(compiled.get(), &count));
    for (std::size_t n = 0; n < count; ++n) {
      auto port = owned<Api::Port>(api.output_const_port_free);
      check(api.compiled_model_input_by_index(compiled.get(), n, port.out()));
      inputs.push_back(portOf(port.get(), type));
      inputTypes.push_back(type);
    }
    check(api.compiled_model_outputs_size(compiled.get(), &count));
    for (std::size_t n = 0; n < count; ++n) {
      auto port = owned<Api::Port>(api.output_const_port_free);
      check(api.compiled_model_output_by_index(compiled.get(), n, port.out()));
      outputs.push_back(portOf(port.get(), type));
    }
    if (inputs.empty() || outputs.empty()) fail(" has no input or no output: give another network.");
  }

  void setInput(const Api::Request* request, std::size_t index, const NetworkTensor& tensor) const {
    const std::size_t count = countOf(tensor.shape);
    const bool whole = std::visit([&](const auto& values) { return values.size() == count; }, tensor.values);
    if (!whole || inputs[index].type == NetworkPort::Type::Other)
      throw Error(ErrorCode::InvalidArgument,
                  name + " has an input '" + inputs[index].name +
                      "' of a type or size that InnerGS does not provide: use another network.");
    std::vector<std::int64_t> sizes = tensor.shape;
    auto made = owned<Api::Tensor>(api.tensor_free);
    check(api.tensor_create(inputTypes[index], {static_cast<std::int64_t>(sizes.size()), sizes.data()},
                            made.out()));
    void* data = nullptr;
    check(api.tensor_data(made.get(), &data));
    std::visit(
        [&](const auto& values) {
          if (inputTypes[index] == Api::Float32)
            copyAs<float>(values, data);
          else if (inputTypes[index] == Api::Int32)
            copyAs<std::int32_t>(values, data);
          else
            copyAs<std::int64_t>(values, data);
        },
        tensor.values);
    if (api.infer_request_set_input_tensor_by_index(const_cast<Api::Request*>(request), index, made.get()) !=
        0)
      throw Error(ErrorCode::InvalidArgument, name + " does not take an input '" + inputs[index].name +
                                                  "' of this size: use another network.");
  }
};

OnnxNetwork::OnnxNetwork(const std::filesystem::path& file, int streams) {
  std::error_code none;
  const std::string path = utf8(file), name = "'" + path + "'";
  if (!std::filesystem::is_regular_file(file, none))
    throw Error(ErrorCode::FileNotFound, "There is no network " + name + ": give an ONNX file.");
  const OpenVino runtime = openVino();
  if (!runtime.functions) throw Error(ErrorCode::NoData, runtime.problem);
  const Api& api = *runtime.functions;
  work_ = std::make_unique<Internals>(api);
  Internals& work = *work_;
  work.name = name;
  if (api.core_create(work.core.out()) != 0)
    throw Error(ErrorCode::NoData, "OpenVINO " + runtime.version + " in '" + utf8(runtime.library) +
                                       "' does not start: install it again.");
  auto model = owned<Api::Model>(api.model_free);
  if (!mayBeOnnx(file) || api.core_read_model(work.core.get(), path.c_str(), nullptr, model.out()) != 0)
    work.fail(" is not an ONNX network that OpenVINO " + runtime.version + " can read: give another file.");
  // Single precision everywhere and a thread per stream, so that results do not depend on a machine's
  // settings.
  const std::string threads = std::to_string(std::max(1, streams));
  const Api::Status compiled = api.core_compile_model(
      work.core.get(), model.get(), "CPU", 6, work.compiled.out(), "INFERENCE_PRECISION_HINT", "f32",
      "INFERENCE_NUM_THREADS", threads.c_str(), "NUM_STREAMS", threads.c_str());
  if (compiled != 0) work.fail(" cannot be compiled by OpenVINO for this CPU: give another network.");
  work.readPorts();
  for (int stream = 0; stream < std::max(1, streams); ++stream) {
    work.requests.emplace_back(api.infer_request_free);
    work.check(api.compiled_model_create_infer_request(work.compiled.get(), work.requests.back().out()));
  }
}

OnnxNetwork::~OnnxNetwork() = default;
OnnxNetwork::OnnxNetwork(OnnxNetwork&&) noexcept = default;

const std::vector<NetworkPort>& OnnxNetwork::inputs() const {
  return work_->inputs;
}
const std::vector<NetworkPort>& OnnxNetwork::outputs() const {
  return work_->outputs;
}
int OnnxNetwork::streams() const {
  return static_cast<int>(work_->requests.size());
}
const std::string& OnnxNetwork::name() const {
  return work_->name;
}

NetworkTensor OnnxNetwork::run(const std::vector<NetworkTensor>& inputs, std::size_t output,
                               int stream) const {
  const Internals& work = *work_;
  const Api& api = work.api;
  if (inputs.size() != work.inputs.size() || output >= work.outputs.size())
    throw Error(ErrorCode::InvalidArgument, work.name + " has " + std::to_string(work.inputs.size()) +
                                                " inputs and " + std::to_string(work.outputs.size()) +
                                                " outputs: use another network.");
  Api::Request* request = work.requests.at(static_cast<std::size_t>(stream)).get();
  for (std::size_t n = 0; n < inputs.size(); ++n)
    work.setInput(request, n, inputs[n]);
  if (api.infer_request_infer(request) != 0)
    throw Error(ErrorCode::InvalidArgument, work.name + " fails on an input of this size: use another "
                                                        "network, or another size.");
  auto tensor = owned<Api::Tensor>(api.tensor_free);
  work.check(api.infer_request_get_output_tensor_by_index(request, output, tensor.out()));
  Api::Type type{};
  work.check(api.tensor_get_element_type(tensor.get(), &type));
  if (type != Api::Float32)
    throw Error(ErrorCode::UnsupportedImage, work.name + " has an output that is not of 32-bit floats: use "
                                                         "another network.");
  NetworkTensor out;
  Api::Shape shape{};
  work.check(api.tensor_get_shape(tensor.get(), &shape));
  out.shape.assign(shape.sizes, shape.sizes + shape.rank);
  api.shape_free(&shape);
  void* data = nullptr;
  work.check(api.tensor_data(tensor.get(), &data));
  const auto* first = static_cast<const float*>(data);
  out.values = std::vector<float>(first, first + countOf(out.shape));
  return out;
}

} // namespace innergs
