#pragma once
#include <cstddef>
#include <cstdint>

namespace innergs {

/// The functions used from OpenVINO's C interface (openvino/c/openvino.h), with its names and layouts.
struct OpenVinoFunctions {
  struct Core;
  struct Model;
  struct CompiledModel;
  struct Request;
  struct Port;
  struct Tensor;
  struct Shape {
    std::int64_t rank;
    std::int64_t* sizes;
  };
  struct Range {
    std::int64_t least, most; // most −1: any size
  };
  struct PartialShape {
    Range rank; // least < most: any rank
    Range* sizes;
  };
  struct Version {
    const char* build;
    const char* description;
  };
  /// The numbers of 2025.4 and later; before, all above 0 were greater by 1.
  enum Type : int { Float32 = 4, Int32 = 9, Int64 = 10 };
  using Status = int; // 0: fine

  Status (*get_openvino_version)(Version*);
  void (*version_free)(Version*);
  Status (*core_create)(Core**);
  void (*core_free)(Core*);
  Status (*core_read_model)(const Core*, const char* path, const char* weights, Model**);
  Status (*core_compile_model)(const Core*, const Model*, const char* device, std::size_t properties,
                               CompiledModel**, ...);
  void (*model_free)(Model*);
  void (*compiled_model_free)(CompiledModel*);
  Status (*compiled_model_inputs_size)(const CompiledModel*, std::size_t*);
  Status (*compiled_model_outputs_size)(const CompiledModel*, std::size_t*);
  Status (*compiled_model_input_by_index)(const CompiledModel*, std::size_t, Port**);
  Status (*compiled_model_output_by_index)(const CompiledModel*, std::size_t, Port**);
  Status (*compiled_model_create_infer_request)(const CompiledModel*, Request**);
  Status (*port_get_any_name)(const Port*, char**);
  Status (*port_get_partial_shape)(const Port*, PartialShape*);
  Status (*port_get_element_type)(const Port*, Type*);
  void (*output_const_port_free)(Port*);
  void (*partial_shape_free)(PartialShape*);
  Status (*tensor_create)(Type, Shape, Tensor**);
  Status (*tensor_get_shape)(const Tensor*, Shape*);
  Status (*tensor_get_element_type)(const Tensor*, Type*);
  Status (*tensor_data)(const Tensor*, void**);
  void (*tensor_free)(Tensor*);
  Status (*shape_free)(Shape*);
  Status (*infer_request_set_input_tensor_by_index)(Request*, std::size_t, const Tensor*);
  Status (*infer_request_get_output_tensor_by_index)(const Request*, std::size_t, Tensor**);
  Status (*infer_request_infer)(Request*);
  void (*infer_request_free)(Request*);
  void (*free)(const char*);
};

} // namespace innergs
