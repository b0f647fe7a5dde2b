#include "SyntheticDicom.h"

#include "Core/Base/NumberText.h"

#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>

#include <vector>

namespace innergs::test {

void writeDicomSlice(const std::filesystem::path& file, const Vec3& origin, const Mat3& direction, int value,
                     const std::map<std::string, std::string>& tags) {
  const ClassicNumbers classic;
  const auto io = itk::GDCMImageIO::New();
  io->SetNumberOfDimensions(3);
  const std::array<itk::SizeValueType, 3> size{6, 5, 1};
  itk::ImageIORegion region(3);
  for (unsigned axis = 0; axis < 3; ++axis) {
    io->SetDimensions(axis, size[axis]);
    region.SetSize(axis, size[axis]);
    io->SetSpacing(axis, 1);
    io->SetOrigin(axis, origin[axis]);
    const Vec3 d = column(direction, static_cast<int>(axis));
    io->SetDirection(axis, std::vector<double>(d.begin(), d.end()));
  }
  io->SetPixelType(itk::CommonEnums::IOPixel::SCALAR);
  io->SetComponentType(itk::CommonEnums::IOComponent::SHORT);
  io->SetNumberOfComponents(1);
  io->SetIORegion(region);
  io->KeepOriginalUIDOn();
  itk::MetaDataDictionary& dictionary = io->GetMetaDataDictionary();
  itk::EncapsulateMetaData<std::string>(dictionary, "0008|0016", "1.2.840.10008.5.1.4.1.1.4"); // MR image
  itk::EncapsulateMetaData<std::string>(dictionary, "0008|0060", "MR");
  for (const auto& [tag, text] : tags)
    itk::EncapsulateMetaData<std::string>(dictionary, tag, text);
  io->SetFileName(file.string());
  const std::vector<short> pixels(30, static_cast<short>(value));
  io->WriteImageInformation();
  io->Write(pixels.data());
}

void writeDicomStack(const std::filesystem::path& folder, const std::string& name, int uid, int count,
                     double step, int first, const Mat3& direction, std::map<std::string, std::string> tags) {
  std::filesystem::create_directories(folder);
  const std::string series = "1.2.3." + std::to_string(uid);
  tags.insert({{"0008|103e", name}, {"0020|000d", "1.2.3"}, {"0020|000e", series}});
  tags.emplace("0020|0011", std::to_string(uid));
  const Vec3 normal = column(direction, 2);
  for (int k = 0; k < count; ++k) {
    const std::string instance = std::to_string(first) + "." + std::to_string(k + 1);
    tags["0008|0018"] = series + "." + instance;
    tags["0020|0013"] = std::to_string(k + 1);
    writeDicomSlice(folder / (std::to_string(uid) + "." + instance + ".dcm"), (k * step) * normal, direction,
                    first + k, tags);
  }
}

} // namespace innergs::test
