#include "Core/Base/Quantities.h"

#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::string bytesText(double bytes) {
  if (bytes < 999.5e3) return formatted("%.0f kB", std::max(1.0, bytes * 1e-3));
  if (bytes < 999.5e6) return formatted("%.0f MB", bytes * 1e-6);
  if (bytes < 99.95e9) return formatted("%.1f GB", bytes * 1e-9);
  return formatted("%.0f GB", std::min(bytes, 1e21) * 1e-9);
}

std::string lengthText(double mm) {
  return formatted(std::abs(mm) < 999.5 ? "%.3g" : "%.0f", mm);
}

std::string countText(std::int64_t count) {
  std::string text = std::to_string(count);
  const int first = count < 0 ? 1 : 0;
  for (int at = static_cast<int>(text.size()) - 3; at > first; at -= 3)
    text.insert(static_cast<std::size_t>(at), ",");
  return text;
}

} // namespace innergs
