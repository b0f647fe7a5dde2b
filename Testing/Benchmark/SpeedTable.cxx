#include "Core/Render/RenderPoints.h"
#include "Markdown.h"
#include "Tables.h"

#include <cmath>

namespace innergs::bench {
namespace {

/// The medians of Google Benchmark's report.
class Medians {
public:
  explicit Medians(const nlohmann::json& report) : rows_(report.at("benchmarks")) {}

  /// The row whose name is `name`, or `name` followed by a slash; nullptr: not measured.
  const nlohmann::json* find(const std::string& name) const {
    for (const auto& row : rows_)
      if (row.value("aggregate_name", "") == "median" &&
          (row.at("run_name").get<std::string>() + "/").starts_with(name + "/"))
        return &row;
    return nullptr;
  }
  double milliseconds(const std::string& name) const {
    const auto* row = find(name);
    return row ? row->at("real_time").get<double>() : NAN;
  }
  double rate(const std::string& name, const char* counter = "pairs_per_second") const {
    const auto* row = find(name);
    return row ? row->at(counter).get<double>() : NAN;
  }
  /// Instruction sets in the order they ran: best first.
  std::vector<std::string> instructionSets() const {
    std::vector<std::string> names;
    for (const auto& row : rows_) {
      const auto name = row.at("run_name").get<std::string>();
      if (row.value("aggregate_name", "") == "median" && name.starts_with("forward/"))
        names.push_back(name.substr(8, name.find('/', 8) - 8));
    }
    return names;
  }

private:
  const nlohmann::json& rows_;
};

std::string rateAndRatio(double rate, double scalar) {
  return fixed(rate / 1e6, 0) + " M/s, " + fixed(rate / scalar, 1) + "× scalar";
}

void addKernels(MarkdownTable& table, const Medians& medians, const std::string& field) {
  const auto sets = medians.instructionSets();
  const double scalarForward = medians.rate("forward/scalar"),
               scalarBackward = medians.rate("backward/scalar");
  for (const auto& set : sets) {
    const double forward = medians.rate("forward/" + set), backward = medians.rate("backward/" + set),
                 cubic = medians.rate("cubic_convolution/" + set, "points_per_second");
    const bool best = &set == &sets.front();
    const auto row = [&](const std::string& what, double rate, double scalar) {
      table.add({what + ", " + set, field + ", 1 core", rateAndRatio(rate, scalar), best ? "≥ 700 M/s" : "",
                 best ? verdict(rate >= 700e6, rate / 1e6 - 700, 0, "M/s") : ""});
    };
    row("voxel evaluations, forward", forward, scalarForward);
    row("voxel evaluations, backward", backward, scalarBackward);
    row("voxel evaluations, both", 2 / (1 / forward + 1 / backward),
        2 / (1 / scalarForward + 1 / scalarBackward));
    table.add({"cubic convolution along oblique rows, points, " + set, field + ", 1 core",
               rateAndRatio(cubic, medians.rate("cubic_convolution/scalar", "points_per_second"))});
  }
}

} // namespace

std::string speedTable(const Outcome& outcome) {
  MarkdownTable table({"what", "measured on", "result", "target", "met"});
  if (!outcome.json) {
    table.add({"micro-benchmarks", "", outcome.missing});
    return table.text();
  }
  const Medians medians(*outcome.json);
  const std::string volume = outcome.json->at("context").value("volume", "");
  const std::string field = "fitted field";
  addKernels(table, medians, field);

  const double one = medians.milliseconds("iteration/threads:1"),
               two = medians.milliseconds("iteration/threads:2");
  table.add({"one training iteration", field + ", 1 thread", fixed(one, 0) + " ms"});
  table.add({"one training iteration", field + ", 2 threads",
             fixed(two, 0) + " ms, " + fixed(one / two, 2) + "× one thread"});
  for (const auto& [axes, what] :
       {std::pair{1, "slices along one axis"}, {3, "slices along all three axes"}}) {
    const double alpha = medians.milliseconds("alpha_iteration/axes:" + std::to_string(axes) + "/threads:2");
    table.add({std::string("one training iteration, alpha blending, ") + what,
               "its own fitted field, 2 threads",
               fixed(alpha, 0) + " ms, " + fixed(alpha / two, 2) + "× normalised over one axis", "≤ 4×",
               verdict(alpha <= 4 * two, alpha / two - 4, 2, "×")});
  }
  if (const auto* fit = medians.find("whole_fit")) {
    const double ratio = fit->at("estimated_over_real").get<double>();
    table.add({"time estimated before the start over the time taken", volume + ", preset fast, 2 threads",
               fixed(ratio, 2), "0.5 to 2",
               verdict(ratio >= 0.5 && ratio <= 2, ratio < 1 ? ratio - 0.5 : ratio - 2, 2, "")});
  }
  const double oblique = medians.milliseconds("oblique_slice");
  table.add({"oblique 512×512 slice, render()", field, fixed(oblique, 1) + " ms", "≤ 50 ms (aim 16)",
             verdict(oblique <= 50, oblique - 50, 1, "ms")});
  const double query = medians.milliseconds("plane_query");
  if (std::isnan(query))
    table.add({"oblique 512×512 plane, vtkInnerGSPlaneQuery", field, "not measured: VTK was not found"});
  else
    table.add({"oblique 512×512 plane that moves, vtkInnerGSPlaneQuery", field,
               fixed(query, 1) + " ms (median of 200)", "≤ 16 ms",
               verdict(query <= 16, query - 16, 1, "ms")});
  for (const auto& [name, what] :
       {std::pair{0, "oblique 512×512 plane of a dynamic scan, which moves at one time"},
        {1, "the same, at another time each"}}) {
    const double plane = medians.milliseconds("moving_plane/new_time:" + std::to_string(name));
    table.add({what, "42,875 Gaussians that are carried (64×64×12 voxels, 12 frames)",
               fixed(plane, 1) + " ms (median of 51)", "≤ 50 ms", verdict(plane <= 50, plane - 50, 1, "ms")});
  }
  table.add({"the whole volume, render()", field, fixed(medians.milliseconds("whole_volume"), 0) + " ms"});
  table.add({"100,000 points, renderPoints()", field + ", uniform in the box",
             fixed(medians.milliseconds("points/points:100000"), 1) + " ms"});
  table.add({"one point, renderPoints()", field, fixed(medians.milliseconds("points/points:1"), 1) + " ms"});
  table.add({"initialisation with its proxy", volume + ", 74,088 Gaussians, 1 thread",
             fixed(medians.milliseconds("initialisation/threads:1"), 0) + " ms"});
  table.add({"initialisation with its proxy", volume + ", 74,088 Gaussians, 2 threads",
             fixed(medians.milliseconds("initialisation/threads:2"), 0) + " ms"});
  for (const auto& [name, what] : {std::pair{"adam", "one Adam step"},
                                   {"projection", "projection onto the grid"},
                                   {"binning", "binning into tiles"}})
    table.add({what, field + ", 1 thread", fixed(medians.milliseconds(name), 2) + " ms"});
  return "Fitted field: 74,088 Gaussians after 40 iterations over " + volume + ".\n\n" + table.text();
}

} // namespace innergs::bench
