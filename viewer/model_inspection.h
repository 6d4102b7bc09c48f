#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "foreview/scene/chart_layout.h"
#include "foreview/scene/polygon_model.h"

namespace foreview {

/// What `foreview inspect` finds out about a model: what the importer did, what textures it would get, and what looks
/// wrong.
struct ModelInspection {
  std::string file;
  ImportOptions import_options;
  ChartOptions chart_options;
  ImportReport report;
  std::vector<std::string> part_names;
  std::vector<std::size_t> part_polygons;  ///< polygons of each part
  double area = 0;                         ///< square metres, without the backdrop
  double largest_extent = 0;               ///< metres, longer side of the largest polygon's box, without the backdrop
  std::size_t polygons_too_large = 0;      ///< for max_texels at the density asked for, without the backdrop
  ChartLayout layout;                      ///< without its charts
  std::size_t charts = 0;                  ///< groups of polygons that share a block, without the backdrop
  std::vector<std::string> findings;       ///< what looks wrong, one line each
};

/// Throws InputError naming the file or option.
[[nodiscard]] ModelInspection inspect_model(const std::filesystem::path& file, const ImportOptions& import_options,
                                            const ChartOptions& chart_options);
/// For people: a few aligned columns, at most 120 wide where names and findings allow.
[[nodiscard]] std::string to_text(const ModelInspection& inspection);
/// For programs: "version": 1.
[[nodiscard]] std::string to_json(const ModelInspection& inspection);

}  // namespace foreview
