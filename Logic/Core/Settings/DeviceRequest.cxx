#include "Core/Settings/DeviceRequest.h"

#include "Core/Base/Error.h"

namespace innergs {

DeviceRequest parseDeviceRequest(const std::string& name) {
  using Kind = DeviceRequest::Kind;
  if (name == "auto") return {};
  if (name == "cpu") return {Kind::Cpu};
  if (name == "cuda") return {Kind::Cuda};
  const std::string digits = name.rfind("cuda:", 0) == 0 ? name.substr(5) : "";
  if (!digits.empty() && digits.size() <= 4 && digits.find_first_not_of("0123456789") == std::string::npos)
    return {Kind::Cuda, std::stoi(digits)};
  throw Error(ErrorCode::InvalidArgument,
              "There is no device '" + name + "': choose auto, cpu, cuda or cuda:N.");
}

} // namespace innergs
