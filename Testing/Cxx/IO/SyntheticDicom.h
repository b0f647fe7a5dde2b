#pragma once
#include "Core/Image/GridGeometry.h"

#include <filesystem>
#include <map>
#include <string>

namespace innergs::test {

/// Writes an MR slice, 6 x 5 pixels of one value, with these additional tags ("0008|103e": text).
void writeDicomSlice(const std::filesystem::path& file, const Vec3& origin, const Mat3& direction, int value,
                     const std::map<std::string, std::string>& tags);

/// Writes `count` slices to a folder, `step` mm apart along the normal, with values first, first + 1 ...
/// Series description and UID: `name`, 1.2.3.`uid`.
void writeDicomStack(const std::filesystem::path& folder, const std::string& name, int uid, int count,
                     double step, int first, const Mat3& direction = {},
                     std::map<std::string, std::string> tags = {});

} // namespace innergs::test
