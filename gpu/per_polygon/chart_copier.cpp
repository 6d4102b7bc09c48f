#include "foreview/gpu/per_polygon/chart_copier.h"

#include "foreview/gpu/dispatch.h"

namespace foreview::per_polygon {

ChartCopier::ChartCopier()
    : copy_(make_compute_program("per_polygon_chart.comp.glsl")),
      adopt_(make_compute_program("per_polygon_adopt.comp.glsl")) {}

void ChartCopier::copy(const PictureData& picture, std::size_t slot, GLuint filled, GLuint fused,
                       const TextureStore& store) {
  const Chart& chart = store.layout().charts[picture.visible()[slot].polygon];
  glUseProgram(copy_.id());
  glUniform1i(0, static_cast<GLint>(slot));
  glBindTextureUnit(0, filled);
  glBindTextureUnit(1, fused);
  glBindImageTexture(0, store.pages(), 0, GL_FALSE, static_cast<GLint>(chart.page), GL_WRITE_ONLY, GL_RGBA8);
  dispatch_over(chart.size.x, chart.size.y);
  image_barrier();
}

void ChartCopier::adopt(const TextureStore& store, std::uint32_t polygon, const PolygonTextures::Item& texture) {
  const Chart& chart = store.layout().charts[polygon];
  const auto in_block = [&](const glm::dvec2& texel) {
    const glm::dvec2 plane = texel / glm::dvec2(texture.width, texture.height) * texture.frame.extent;
    return chart.texel_from_part(texture.frame.part_from_plane(plane)) - glm::dvec2(chart.origin);
  };
  const glm::vec2 origin = in_block({0, 0}), column = in_block({1, 0}) - in_block({0, 0}),
                  row = in_block({0, 1}) - in_block({0, 0});
  glUseProgram(adopt_.id());
  glUniform2i(0, texture.width, texture.height);
  glUniform4i(1, chart.origin.x, chart.origin.y, chart.size.x, chart.size.y);
  glUniform1i(2, static_cast<GLint>(chart.page));
  glUniform4f(3, column.x, column.y, row.x, row.y);
  glUniform2f(4, origin.x, origin.y);
  glBindTextureUnit(0, store.pages());
  glBindImageTexture(0, texture.texture.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8);
  dispatch_over(texture.width, texture.height);
}

}  // namespace foreview::per_polygon
