#include "Scores.h"
#include "Markdown.h"

#include <algorithm>
#include <cmath>

namespace innergs::bench {

double Scores::get(const std::string& method, const std::string& key) const {
  const nlohmann::json::json_pointer place("/" + method + "/" + key);
  return methods_.contains(place) && methods_.at(place).is_number() ? methods_.at(place).get<double>() : NAN;
}

double Scores::best(std::initializer_list<const char*> methods, const std::string& key) const {
  double most = -INFINITY;
  for (const char* method : methods)
    most = std::fmax(most, get(method, key));
  return most;
}

std::string Scores::text(const std::string& method) const {
  return std::isnan(psnr(method)) ? "" : fixed(psnr(method), 2) + " / " + fixed(get(method, "ssim"), 4);
}

} // namespace innergs::bench
