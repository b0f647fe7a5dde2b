#include "IO/SegmentNames.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/FilePath.h"
#include "IO/ItkImage.h"

#include <itkMetaDataObject.h>
#include <itkNrrdImageIO.h>
#include <nlohmann/json.hpp>

#include <charconv>
#include <fstream>
#include <optional>

namespace innergs {
namespace {

using nlohmann::json;

std::optional<std::uint16_t> labelOf(const std::string& text) {
  std::uint16_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) return {};
  return value;
}

std::vector<SegmentName> namesOfJson(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const json file = json::parse(in, nullptr, false);
  std::vector<SegmentName> names;
  const auto fail = [&] {
    throw Error(ErrorCode::FileFormat,
                quoted(path) + " does not name segments; write {\"1\": \"liver\", \"2\": \"spleen\"}.");
  };
  if (!file.is_object() || file.empty()) fail();
  for (const auto& [key, value] : file.items()) {
    SegmentName name;
    if (value.is_string()) {
      const auto label = labelOf(key);
      if (!label) fail();
      name = {*label, value.get<std::string>()};
    } else if (value.is_number_unsigned() && value.get<std::uint64_t>() <= 65535) {
      name = {value.get<std::uint16_t>(), key};
    } else {
      fail();
    }
    if (name.label != 0) names.push_back(std::move(name)); // 0 is the background
  }
  return names;
}

std::vector<SegmentName> namesOfHeader(const std::filesystem::path& path) {
  return withItk(
      ErrorCode::FileFormat, quoted(path) + " is truncated or damaged; copy or export it again.", [&] {
        std::vector<SegmentName> names;
        const auto io = itk::NrrdImageIO::New();
        io->SetFileName(utf8(path));
        io->ReadImageInformation();
        const itk::MetaDataDictionary& fields = io->GetMetaDataDictionary();
        for (int n = 0; n < 65536; ++n) {
          const std::string segment = "Segment" + std::to_string(n) + "_";
          std::string name, label, layer = "0";
          if (!itk::ExposeMetaData<std::string>(fields, segment + "ID", name)) break;
          itk::ExposeMetaData<std::string>(fields, segment + "Name", name);
          itk::ExposeMetaData<std::string>(fields, segment + "LabelValue", label);
          itk::ExposeMetaData<std::string>(fields, segment + "Layer", layer);
          if (layer != "0")
            throw Error(ErrorCode::UnsupportedImage,
                        quoted(path) + " has segments that overlap; export it as a labelmap volume.");
          const auto value = labelOf(label);
          if (value && *value != 0) names.push_back({*value, name});
        }
        return names;
      });
}

} // namespace

std::vector<SegmentName> readSegmentNames(const std::filesystem::path& path) {
  checkInputFile(path);
  if (fullExtension(path) == ".json") return namesOfJson(path);
  char start[8] = {};
  std::ifstream(path, std::ios::binary).read(start, 7);
  return std::string(start) == "NRRD000" ? namesOfHeader(path) : std::vector<SegmentName>{};
}

std::map<std::string, std::string> segmentFields(const std::vector<SegmentInfo>& segments,
                                                 const GridGeometry& geometry) {
  std::string extent;
  for (int a = 0; a < 3; ++a)
    extent += (a ? " 0 " : "0 ") + std::to_string(geometry.size[a] - 1);
  std::map<std::string, std::string> fields;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const SegmentInfo& s = segments[n];
    const std::string segment = "Segment" + std::to_string(n) + "_";
    fields[segment + "ID"] = "Segment_" + std::to_string(n + 1);
    fields[segment + "Name"] = s.name.name;
    fields[segment + "LabelValue"] = std::to_string(s.name.label);
    fields[segment + "Layer"] = "0";
    fields[segment + "Extent"] = extent;
    fields[segment + "Color"] =
        exactText(s.color[0]) + " " + exactText(s.color[1]) + " " + exactText(s.color[2]);
    if (!s.terminology.empty()) fields[segment + "Tags"] = "TerminologyEntry:" + s.terminology + "|";
  }
  return fields;
}

} // namespace innergs
