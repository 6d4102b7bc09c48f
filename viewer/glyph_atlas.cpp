#include "foreview/viewer/glyph_atlas.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace foreview {
namespace {

constexpr int kColumns = 16, kRows = 6;
constexpr int kCellWidth = 48, kCellHeight = 48;  // texels; a line is as high as a cell
constexpr int kMargin = 6, kBaseline = 36;
constexpr double kScale = 1.15;  // of OpenCV's font: capitals 25 texels high
constexpr int kThickness = 3;
constexpr char kFirst = ' ';

}  // namespace

GlyphAtlas::GlyphAtlas() {
  cv::Mat atlas(kRows * kCellHeight, kColumns * kCellWidth, CV_8UC1, cv::Scalar::all(0));
  for (int i = 0; i < static_cast<int>(glyphs_.size()); ++i) {
    const std::string text(1, static_cast<char>(kFirst + i));
    const cv::Rect cell(i % kColumns * kCellWidth, i / kColumns * kCellHeight, kCellWidth, kCellHeight);
    cv::Mat there = atlas(cell);  // a part of the atlas: strokes do not reach into the next cell
    cv::putText(there, text, {kMargin, kBaseline}, cv::FONT_HERSHEY_SIMPLEX, kScale, cv::Scalar::all(255), kThickness,
                cv::LINE_AA);
    int below = 0;
    const int advance = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kScale, 1, &below).width;
    Glyph& glyph = glyphs_[static_cast<std::size_t>(i)];
    const glm::vec2 size(atlas.cols, atlas.rows);
    glyph.first = glm::vec2(cell.x, cell.y) / size;
    glyph.last = glm::vec2(cell.x + cell.width, cell.y + cell.height) / size;
    glyph.width = static_cast<float>(kCellWidth) / kCellHeight;
    glyph.advance = static_cast<float>(advance) / kCellHeight;
  }
  constexpr int kLevels = 4;  // a level more would mix cells: 48 is three times 16
  texture_ = make_texture_2d(GL_R8, atlas.cols, atlas.rows, kLevels);
  // Not by glGenerateTextureMipmap(): the first use of it makes shaders, which takes longer than all of this.
  for (int level = 0; level < kLevels; ++level) {
    glTextureSubImage2D(texture_.id(), level, 0, 0, atlas.cols, atlas.rows, GL_RED, GL_UNSIGNED_BYTE, atlas.data);
    cv::Mat half;
    cv::resize(atlas, half, {}, 0.5, 0.5, cv::INTER_AREA);
    atlas = half;
  }
}

const GlyphAtlas::Glyph& GlyphAtlas::glyph(char character) const {
  const int index = character - kFirst;
  const bool known = index >= 0 && index < static_cast<int>(glyphs_.size());
  return glyphs_[static_cast<std::size_t>(known ? index : '?' - kFirst)];
}

float GlyphAtlas::width(std::string_view text) const {
  float sum = 0;
  for (const char character : text) sum += glyph(character).advance;
  return sum;
}

}  // namespace foreview
