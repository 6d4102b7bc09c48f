#include "foreview/viewer/model_inspection.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

namespace foreview {
namespace {

/// 12345678 as "12,345,678".
std::string grouped(std::size_t count) {
  std::string digits = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), ",");
  return digits;
}

std::string length_text(double metres) {
  if (metres >= 1) return fmt::format("{:.2f} m", metres);
  if (metres >= 0.01) return fmt::format("{:.1f} cm", metres * 100);
  return fmt::format("{:.2f} mm", metres * 1000);
}

double polygon_area(const PolygonModel& model, std::size_t polygon) {
  double area = 0;
  const glm::dvec3 first = model.corner(polygon, 0);
  for (std::size_t i = 1; i + 1 < model.polygons()[polygon].corner_count; ++i)
    area += 0.5 * glm::dot(model.polygons()[polygon].normal,
                           glm::cross(model.corner(polygon, i) - first, model.corner(polygon, i + 1) - first));
  return area;
}

double texels_per_useful(const ChartLayout& layout) {
  return layout.useful_texels > 0 ? layout.written_texels / layout.useful_texels : 0;
}

void add_texture_findings(ModelInspection& result) {
  if (result.polygons_too_large > 0)
    result.findings.push_back(fmt::format(
        "{} polygons are wider than the {} that {} texels give at {:g} texels per metre: they get coarser texels "
        "(largest: {})",
        grouped(result.polygons_too_large),
        length_text(result.chart_options.max_texels / result.chart_options.texels_per_metre),
        result.chart_options.max_texels, result.chart_options.texels_per_metre, length_text(result.largest_extent)));
  for (const std::string& note : result.layout.notes) result.findings.push_back(note);
  if (const double ratio = texels_per_useful(result.layout); ratio > 2)
    result.findings.push_back(fmt::format(
        "{:.1f} texels are written for each useful one (at most 2 is good): the polygons are small for this "
        "density; simplify the mesh",
        ratio));
}

class Table {
 public:
  void heading(const std::string& text) { text_ += "\n" + text + "\n"; }
  void row(const std::string& label, const std::string& value) { text_ += fmt::format("  {:<34}{}\n", label, value); }
  void count(const std::string& label, std::size_t value) {
    if (value > 0) row(label, grouped(value));
    any_ = any_ || value > 0;
  }
  void line(const std::string& text) { text_ += text + "\n"; }
  [[nodiscard]] bool take_any() { return std::exchange(any_, false); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
  bool any_ = false;
};

void add_parts(Table& table, const ModelInspection& inspection) {
  constexpr std::size_t kShown = 20;
  const std::size_t count = inspection.part_names.size();
  for (std::size_t i = 0; i < std::min(count, kShown); ++i)
    table.row(i == 0 ? "parts" : "",
              inspection.part_names[i] + " (" + grouped(inspection.part_polygons[i]) + " polygons)");
  if (count > kShown) table.row("", "and " + grouped(count - kShown) + " more");
}

}  // namespace

ModelInspection inspect_model(const std::filesystem::path& file, const ImportOptions& import_options,
                              const ChartOptions& chart_options) {
  ModelInspection result;
  result.file = file.string();
  result.import_options = import_options;
  result.chart_options = chart_options;
  const PolygonModel model = import_model(file, import_options, &result.report);
  result.layout = lay_out_charts(model, chart_options);
  for (const Part& part : model.parts()) result.part_names.push_back(part.name);
  result.part_polygons.assign(model.parts().size(), 0);
  const double largest = chart_options.max_texels / chart_options.texels_per_metre;
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    ++result.part_polygons[model.polygons()[i].part];
    if (model.polygons()[i].is_backdrop) continue;
    result.area += polygon_area(model, i);
    const glm::dvec2 extent = polygon_frame(model, i).extent;
    const double longer = std::max(extent.x, extent.y);
    result.largest_extent = std::max(result.largest_extent, longer);
    result.polygons_too_large += longer > largest * (1 + 1e-9) ? 1 : 0;
  }
  result.layout.charts.clear();
  for (const ChartGroup& group : result.layout.groups)
    result.charts += model.polygons()[result.layout.members[group.first_member]].is_backdrop ? 0 : 1;
  result.findings = result.report.warnings;
  add_texture_findings(result);
  return result;
}

std::string to_text(const ModelInspection& inspection) {
  const ImportReport& r = inspection.report;
  const ChartLayout& layout = inspection.layout;
  Table table;
  table.line(inspection.file);
  table.row("in the file", grouped(r.faces_in) + " faces, " + grouped(r.vertices_in) + " vertices");
  table.row("polygons",
            grouped(r.polygons_out - r.backdrop_polygons) +
                (r.backdrop_polygons > 0 ? " and " + grouped(r.backdrop_polygons) + " of the backdrop" : ""));
  add_parts(table, inspection);
  const glm::dvec3 size = r.bounds_max - r.bounds_min;
  table.row("size", length_text(size.x) + " x " + length_text(size.y) + " x " + length_text(size.z) +
                        fmt::format(", from ({:.3f}, {:.3f}, {:.3f}) to ({:.3f}, {:.3f}, {:.3f})", r.bounds_min.x,
                                    r.bounds_min.y, r.bounds_min.z, r.bounds_max.x, r.bounds_max.y, r.bounds_max.z));
  table.row("surface", fmt::format("{:.4g} m2", inspection.area));
  table.row("median edge", length_text(r.median_edge));

  table.heading("What the importer did");
  table.count("faces merged into larger polygons", r.faces_merged);
  table.count("faces split: not planar", r.faces_split_not_planar);
  table.count("faces split: concave", r.faces_split_concave);
  table.count("faces that cross themselves", r.faces_self_crossing);
  table.count("faces dropped: bad index", r.faces_with_bad_index);
  table.count("faces dropped: not finite", r.faces_not_finite);
  table.count("faces dropped: no area", r.faces_degenerate);
  table.count("faces dropped: duplicate", r.faces_duplicate);
  table.count("faces dropped: too many corners", r.faces_too_complex);
  table.count("vertices welded", r.vertices_welded);
  table.count("vertices split, non-manifold", r.vertices_split);
  if (!table.take_any()) table.line("  nothing: every face is a polygon as it is");

  table.heading("Edges");
  table.row("boundary: holes and rims", grouped(r.boundary_edges) + " in " + grouped(r.boundary_loops) + " loops");
  table.row("of opposed winding", grouped(r.edges_with_opposed_winding));
  table.row("with three or more faces", grouped(r.edges_not_manifold));

  table.heading(fmt::format("Textures at {:g} texels per metre, at most {} along an axis",
                            inspection.chart_options.texels_per_metre, inspection.chart_options.max_texels));
  table.row("charts, without the backdrop", grouped(inspection.charts));
  table.row("useful texels", grouped(static_cast<std::size_t>(layout.useful_texels)));
  table.row("texels written per useful texel", fmt::format("{:.2f}", texels_per_useful(layout)));
  table.row("atlas pages", fmt::format("{} of {} x {} texels", layout.pages, layout.page_size, layout.page_size));
  table.row("texture memory", fmt::format("{:.1f} MiB", static_cast<double>(layout.memory_bytes) / (1 << 20)));
  table.row("polygons too large for that", grouped(inspection.polygons_too_large));
  table.row("largest polygon", length_text(inspection.largest_extent));

  table.heading("What looks wrong");
  for (const std::string& finding : inspection.findings) table.line("  - " + finding);
  if (inspection.findings.empty()) table.line("  nothing");
  return table.text();
}

std::string to_json(const ModelInspection& inspection) {
  const ImportReport& r = inspection.report;
  const ChartLayout& layout = inspection.layout;
  const auto vector = [](const glm::dvec3& v) { return nlohmann::ordered_json::array({v.x, v.y, v.z}); };
  nlohmann::ordered_json parts = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < inspection.part_names.size(); ++i)
    parts.push_back({{"name", inspection.part_names[i]}, {"polygons", inspection.part_polygons[i]}});
  const nlohmann::ordered_json json = {{"version", 1},
                                       {"file", inspection.file},
                                       {"options",
                                        {{"scale", inspection.import_options.scale},
                                         {"merge_coplanar", inspection.import_options.merge_coplanar},
                                         {"backdrop", inspection.import_options.backdrop},
                                         {"texels_per_metre", inspection.chart_options.texels_per_metre},
                                         {"max_texels", inspection.chart_options.max_texels}}},
                                       {"faces_in", r.faces_in},
                                       {"vertices_in", r.vertices_in},
                                       {"polygons", r.polygons_out},
                                       {"backdrop_polygons", r.backdrop_polygons},
                                       {"parts", parts},
                                       {"bounds_min", vector(r.bounds_min)},
                                       {"bounds_max", vector(r.bounds_max)},
                                       {"area", inspection.area},
                                       {"median_edge", r.median_edge},
                                       {"largest_extent", inspection.largest_extent},
                                       {"importer",
                                        {{"faces_merged", r.faces_merged},
                                         {"faces_split_not_planar", r.faces_split_not_planar},
                                         {"faces_split_concave", r.faces_split_concave},
                                         {"faces_self_crossing", r.faces_self_crossing},
                                         {"faces_with_bad_index", r.faces_with_bad_index},
                                         {"faces_not_finite", r.faces_not_finite},
                                         {"faces_degenerate", r.faces_degenerate},
                                         {"faces_duplicate", r.faces_duplicate},
                                         {"faces_too_complex", r.faces_too_complex},
                                         {"vertices_welded", r.vertices_welded},
                                         {"vertices_split", r.vertices_split}}},
                                       {"edges",
                                        {{"boundary", r.boundary_edges},
                                         {"boundary_loops", r.boundary_loops},
                                         {"opposed_winding", r.edges_with_opposed_winding},
                                         {"not_manifold", r.edges_not_manifold}}},
                                       {"textures",
                                        {{"charts", inspection.charts},
                                         {"useful_texels", layout.useful_texels},
                                         {"written_texels", layout.written_texels},
                                         {"texels_per_useful_texel", texels_per_useful(layout)},
                                         {"pages", layout.pages},
                                         {"page_size", layout.page_size},
                                         {"allocated_texels", layout.allocated_texels},
                                         {"memory_bytes", layout.memory_bytes},
                                         {"polygons_too_large", inspection.polygons_too_large},
                                         {"polygons_lowered", layout.polygons_lowered}}},
                                       {"findings", inspection.findings}};
  // Names come from files: what is not UTF-8 is replaced, not thrown about.
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace foreview
