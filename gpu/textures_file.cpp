#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "foreview/gpu/texture_store.h"
#include "foreview/gpu/textures_format.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/input_file.h"
#include "foreview/scene/output_file.h"

namespace foreview {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIndexFile = "textures.yaml";
constexpr const char* kStatesFile = "polygon-states.csv";
constexpr std::size_t kMaxIndexBytes = 64 * 1024;

std::string page_file(std::size_t page) {
  char name[40];
  std::snprintf(name, sizeof name, "page-%03zu.png", page);
  return name;
}

std::string_view view(const std::vector<unsigned char>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Reads a file that must be the one that was saved.
std::string read_checked(const fs::path& file, std::size_t max_bytes, std::uint64_t checksum) {
  std::string bytes = read_input_file(file, max_bytes);
  if (file_checksum(bytes) != checksum) {
    throw InputError(file.string(), std::string("is damaged, or not the file that ") + kIndexFile +
                                        " was saved with: its checksum differs");
  }
  return bytes;
}

cv::Mat decode_page(const std::string& bytes, const fs::path& file, int page_size) {
  const std::string wanted = "expected an RGBA PNG of " + std::to_string(page_size) + " x " + std::to_string(page_size);
  // Before decoding, which allocates what the header claims.
  std::uint32_t width = 0, height = 0;
  if (!read_rgba_png_size(bytes, width, height)) throw InputError(file.string(), "is something else; " + wanted);
  if (width != static_cast<std::uint32_t>(page_size) || height != static_cast<std::uint32_t>(page_size)) {
    throw InputError(file.string(), "is of " + std::to_string(width) + " x " + std::to_string(height) + "; " + wanted);
  }
  cv::Mat page;
  try {
    page = cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())),
                        cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    page.release();
  }
  if (page.type() != CV_8UC4 || page.cols != page_size || page.rows != page_size) {
    throw InputError(file.string(), "cannot be decoded; " + wanted);
  }
  return page;
}

}  // namespace

void save_textures(const TextureStore& store, const fs::path& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw InputError(directory.string(), "cannot be created: " + error.message());

  std::vector<std::string> files;
  const auto write_beside = [&](const std::string& name, std::string_view bytes) {
    write_file_whole(directory / (name + ".new"), bytes);
    files.push_back(name);
  };
  TexturesIndex index;
  index.model_fingerprint = store.model().fingerprint();
  index.layout_fingerprint = layout_fingerprint(store.layout());
  index.polygons = static_cast<int>(store.model().polygons().size());
  index.charts = static_cast<int>(store.layout().groups.size());
  index.page_size = store.layout().page_size;
  // With the exposure in them, so that files show what was shown, and fit whatever goes on with them.
  const TextureStore::Contents contents = store.read_as_shown();
  for (const cv::Mat& page : contents.pages) {
    std::vector<unsigned char> png;
    if (!cv::imencode(".png", page, png)) throw InputError(directory.string(), "a page cannot be encoded as PNG");
    index.page_checksums.push_back(file_checksum(view(png)));
    write_beside(page_file(files.size()), view(png));
  }
  const std::string states = to_states_csv(contents.states);
  index.states_checksum = file_checksum(states);
  write_beside(kStatesFile, states);
  write_beside(kIndexFile, to_textures_yaml(index));

  // The index last: until it is replaced, its checksums tell that the rest is on the way.
  for (const std::string& name : files) replace_file(directory / (name + ".new"), directory / name);
  // Pages of an earlier, larger set of textures.
  for (std::size_t page = store.layout().pages; fs::remove(directory / page_file(page), error); ++page) {
  }
}

void load_textures(TextureStore& store, const fs::path& directory) {
  if (!fs::is_directory(directory)) {
    throw InputError(directory.string(), "is no directory; expected one that --save-textures made");
  }
  const fs::path index_file = directory / kIndexFile;
  const TexturesIndex index = parse_textures_yaml(read_input_file(index_file, kMaxIndexBytes), index_file.string());
  if (index.model_fingerprint != store.model().fingerprint()) {
    throw InputError(index_file.string(), "these textures belong to another model (model_fingerprint differs)");
  }
  const ChartLayout& layout = store.layout();
  const std::size_t charts = layout.groups.size();
  if (static_cast<std::size_t>(index.charts) != charts) {
    throw InputError(index_file.string(), "these textures lie in " + std::to_string(index.charts) +
                                              " charts, but here the polygons share " + std::to_string(charts) +
                                              "; use the same --pipeline, --density and --max-texels as when they "
                                              "were saved");
  }
  if (index.layout_fingerprint != layout_fingerprint(layout)) {
    throw InputError(index_file.string(),
                     "these textures were made with other sizes (layout_fingerprint differs); use the same --density, "
                     "--max-texels and --pipeline as when they were saved");
  }
  const std::size_t polygons = store.model().polygons().size();
  if (static_cast<std::size_t>(index.polygons) != polygons || index.page_size != layout.page_size ||
      index.page_checksums.size() != layout.pages) {
    throw InputError(index_file.string(), "its figures contradict its fingerprints; expected " +
                                              std::to_string(polygons) + " polygons and " +
                                              std::to_string(layout.pages) + " pages of " +
                                              std::to_string(layout.page_size) + " texels");
  }

  const fs::path states_file = directory / kStatesFile;
  constexpr std::size_t kMaxBytesPerLine = 128;
  const std::string states_text = read_checked(states_file, (polygons + 1) * kMaxBytesPerLine, index.states_checksum);
  const std::vector<TextureStore::PolygonState> states = parse_states_csv(states_text, states_file.string(), polygons);

  const auto side = static_cast<std::size_t>(layout.page_size);
  const std::size_t max_page_bytes = side * side * 5 + 65536;  // no PNG writer makes a page larger than its pixels
  std::vector<cv::Mat> pages;
  for (std::size_t i = 0; i < layout.pages; ++i) {
    const fs::path file = directory / page_file(i);
    pages.push_back(decode_page(read_checked(file, max_page_bytes, index.page_checksums[i]), file, layout.page_size));
  }
  store.write_pages(pages, states);
}

}  // namespace foreview
