#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "foreview/gpu/texture_store.h"
#include "foreview/scene/errors.h"
#include "foreview/scene/output_file.h"

namespace foreview {
namespace {

using nlohmann::json;

// Numbers of the glTF 2.0 specification.
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kFloat = 5126, kUnsignedInt = 5125;
constexpr int kLinear = 9729, kClampToEdge = 33071;
constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

/// The second component of a texture coordinate or colour stream differs: 2 floats or 3.
struct Primitive {
  std::vector<std::array<float, 3>> positions;
  std::vector<float> attribute;
  std::vector<std::uint32_t> indices;
};

/// glTF wants vertex colours linear, and pages and polygon states hold what cameras give: sRGB.
float linear_from_srgb(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

/// Size of the upper left part of every page that polygons take colours from; 0 where none does.
std::vector<cv::Size> used_sizes(const TextureStore& store, const std::vector<bool>& textured) {
  std::vector<cv::Size> sizes(store.layout().pages);
  for (std::size_t i = 0; i < textured.size(); ++i) {
    if (!textured[i]) continue;
    const Chart& chart = store.layout().charts[i];
    sizes[chart.page].width = std::max(sizes[chart.page].width, chart.origin.x + chart.size.x);
    sizes[chart.page].height = std::max(sizes[chart.page].height, chart.origin.y + chart.size.y);
  }
  return sizes;
}

/// The JSON document and the binary chunk, growing together.
class GlbBuilder {
 public:
  GlbBuilder() {
    document_["asset"] = {{"version", "2.0"}, {"generator", "foreview"}};
    document_["extensionsUsed"] = {"KHR_materials_unlit"};
    for (const char* name : {"bufferViews", "accessors", "materials", "meshes", "nodes"}) {
      document_[name] = json::array();
    }
  }

  /// Index of a material that shows this picture (BGR), as it is.
  std::size_t add_textured_material(const cv::Mat& picture, const std::string& name) {
    std::vector<unsigned char> png;
    if (!cv::imencode(".png", picture, png)) throw InputError(name, "cannot be encoded as PNG");
    if (!document_.contains("samplers")) {
      // No mip levels: those that a viewer makes would mix charts.
      document_["samplers"] = {
          {{"magFilter", kLinear}, {"minFilter", kLinear}, {"wrapS", kClampToEdge}, {"wrapT", kClampToEdge}}};
    }
    document_["images"].push_back(
        {{"bufferView", add_view(png.data(), png.size(), 0)}, {"mimeType", "image/png"}, {"name", name}});
    document_["textures"].push_back({{"sampler", 0}, {"source", document_["images"].size() - 1}});
    return add_material(name, {{"baseColorTexture", {{"index", document_["textures"].size() - 1}}}});
  }

  std::size_t add_material(const std::string& name, json pbr) {
    pbr["metallicFactor"] = 0.0;
    pbr["roughnessFactor"] = 1.0;
    document_["materials"].push_back({{"name", name},
                                      {"pbrMetallicRoughness", std::move(pbr)},
                                      {"extensions", {{"KHR_materials_unlit", json::object()}}}});
    return document_["materials"].size() - 1;
  }

  json add_primitive(const Primitive& primitive, const char* attribute, std::size_t components, std::size_t material) {
    std::array<float, 3> least, greatest;
    least.fill(std::numeric_limits<float>::max());
    greatest.fill(std::numeric_limits<float>::lowest());
    for (const auto& p : primitive.positions) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        least[axis] = std::min(least[axis], p[axis]);
        greatest[axis] = std::max(greatest[axis], p[axis]);
      }
    }
    const std::size_t count = primitive.positions.size();
    const std::size_t positions = add_accessor(primitive.positions.data(), count * 12, count, "VEC3", kFloat,
                                               kArrayBuffer, {{"min", least}, {"max", greatest}});
    const std::size_t attributes =
        add_accessor(primitive.attribute.data(), primitive.attribute.size() * sizeof(float), count,
                     components == 2 ? "VEC2" : "VEC3", kFloat, kArrayBuffer, json::object());
    const std::size_t indices =
        add_accessor(primitive.indices.data(), primitive.indices.size() * sizeof(std::uint32_t),
                     primitive.indices.size(), "SCALAR", kUnsignedInt, kElementArrayBuffer, json::object());
    return {{"attributes", {{"POSITION", positions}, {attribute, attributes}}},
            {"indices", indices},
            {"material", material}};
  }

  std::size_t add_mesh(const std::string& name, json primitives) {
    document_["meshes"].push_back({{"name", name}, {"primitives", std::move(primitives)}});
    return document_["meshes"].size() - 1;
  }
  std::size_t add_node(json node) {
    document_["nodes"].push_back(std::move(node));
    return document_["nodes"].size() - 1;
  }

  void write(std::size_t root_node, const std::filesystem::path& file) {
    document_["scenes"] = {{{"nodes", {root_node}}}};
    document_["scene"] = 0;
    document_["buffers"] = {{{"byteLength", binary_.size()}}};
    // Names of parts come from files, and need not be UTF-8.
    std::string text = document_.dump(-1, ' ', false, json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t length = 12 + 8 + text.size() + 8 + binary_.size();
    if (length > std::numeric_limits<std::uint32_t>::max()) {
      throw InputError(file.string(), "would be larger than the 4 GiB that binary glTF allows; use a lower --density");
    }
    const auto word = [](std::size_t value) { return static_cast<std::uint32_t>(value); };
    const std::array<std::uint32_t, 5> head{kGlbMagic, 2, word(length), word(text.size()), kJsonChunk};
    const std::array<std::uint32_t, 2> binary_head{word(binary_.size()), kBinaryChunk};
    write_file_whole(file, {{reinterpret_cast<const char*>(head.data()), sizeof head},
                            text,
                            {reinterpret_cast<const char*>(binary_head.data()), sizeof binary_head},
                            binary_});
  }

 private:
  std::size_t add_view(const void* data, std::size_t bytes, int target) {
    json view{{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes}};
    if (target != 0) view["target"] = target;
    binary_.append(static_cast<const char*>(data), bytes);
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
    document_["bufferViews"].push_back(std::move(view));
    return document_["bufferViews"].size() - 1;
  }
  std::size_t add_accessor(const void* data, std::size_t bytes, std::size_t count, const char* type, int component,
                           int target, json more) {
    more["bufferView"] = add_view(data, bytes, target);
    more["componentType"] = component;
    more["count"] = count;
    more["type"] = type;
    document_["accessors"].push_back(std::move(more));
    return document_["accessors"].size() - 1;
  }

  json document_;
  std::string binary_;
};

/// A part's polygons: one primitive per page, the last one for polygons without texture.
std::vector<Primitive> part_primitives(const TextureStore& store, std::uint32_t part, bool with_backdrop,
                                       const std::vector<bool>& textured,
                                       const std::vector<TextureStore::PolygonState>& states,
                                       const std::vector<cv::Size>& sizes) {
  const PolygonModel& model = store.model();
  std::vector<Primitive> primitives(sizes.size() + 1);
  for (std::size_t i = 0; i < model.polygons().size(); ++i) {
    const Polygon& polygon = model.polygons()[i];
    if (polygon.part != part || (polygon.is_backdrop && !with_backdrop)) continue;
    const Chart& chart = store.layout().charts[i];
    Primitive& primitive = textured[i] ? primitives[chart.page] : primitives.back();
    const auto first = static_cast<std::uint32_t>(primitive.positions.size());
    for (std::size_t k = 0; k < polygon.corner_count; ++k) {
      const glm::dvec3& p = model.corner(i, k);
      primitive.positions.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
      if (textured[i]) {
        const glm::dvec2 texel = chart.texel_from_part(p);
        primitive.attribute.push_back(static_cast<float>(texel.x / sizes[chart.page].width));
        primitive.attribute.push_back(static_cast<float>(texel.y / sizes[chart.page].height));
      } else {
        for (const float c : {states[i].red, states[i].green, states[i].blue}) {
          primitive.attribute.push_back(linear_from_srgb(c));
        }
      }
    }
    for (std::uint32_t k = 2; k < polygon.corner_count; ++k) {
      primitive.indices.insert(primitive.indices.end(), {first, first + k - 1, first + k});
    }
  }
  return primitives;
}

}  // namespace

void export_glb(const TextureStore& store, const std::vector<Pose>& world_from_part, const std::filesystem::path& file,
                bool with_backdrop) {
  const PolygonModel& model = store.model();
  assert(world_from_part.size() == model.parts().size());
  const auto [pages, states] = store.read_as_shown();
  std::vector<bool> textured(states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    textured[i] = states[i].seen == 1.0F && (with_backdrop || !model.polygons()[i].is_backdrop);
  }
  const std::vector<cv::Size> sizes = used_sizes(store, textured);

  GlbBuilder builder;
  std::vector<std::size_t> materials(sizes.size() + 1);
  for (std::size_t page = 0; page < sizes.size(); ++page) {
    if (sizes[page].empty()) continue;
    cv::Mat picture;
    cv::cvtColor(pages[page](cv::Rect({0, 0}, sizes[page])), picture, cv::COLOR_BGRA2BGR);
    materials[page] = builder.add_textured_material(picture, "page-" + std::to_string(page));
  }
  std::optional<std::size_t> never_seen_material;

  json children = json::array();
  for (std::uint32_t part = 0; part < model.parts().size(); ++part) {
    json primitives = json::array();
    const std::vector<Primitive> by_page = part_primitives(store, part, with_backdrop, textured, states, sizes);
    for (std::size_t page = 0; page < by_page.size(); ++page) {
      if (by_page[page].positions.empty()) continue;
      const bool has_texture = page < sizes.size();
      if (!has_texture && !never_seen_material)
        never_seen_material = builder.add_material("never-seen", json::object());
      primitives.push_back(builder.add_primitive(by_page[page], has_texture ? "TEXCOORD_0" : "COLOR_0",
                                                 has_texture ? 2 : 3,
                                                 has_texture ? materials[page] : *never_seen_material));
    }
    const Pose& pose = world_from_part[part];
    json node{{"name", model.parts()[part].name},
              {"translation", {pose.translation.x, pose.translation.y, pose.translation.z}},
              {"rotation", {pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w}}};
    if (!primitives.empty()) node["mesh"] = builder.add_mesh(model.parts()[part].name, std::move(primitives));
    children.push_back(builder.add_node(std::move(node)));
  }
  // Our world's z is up, glTF's y: a quarter turn about x.
  const double half = std::numbers::sqrt2 / 2;
  const std::size_t root = builder.add_node(
      {{"name", "foreview"}, {"rotation", {-half, 0.0, 0.0, half}}, {"children", std::move(children)}});
  builder.write(root, file);
}

}  // namespace foreview
