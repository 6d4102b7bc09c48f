#include "foreview/viewer/bench_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "foreview/viewer/bench_table.h"

namespace foreview {
namespace {

constexpr double kLeft = 62, kRight = 14, kTop = 12, kBottom = 44;  // pixels around the plot's area
constexpr int kTicks = 6;                                           // about so many, where linear

template <typename... Values>
std::string text_of(const char* format, Values... values) {
  char text[320];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// 1, 2 or 5 times a power of ten, not below `value`.
double round_step(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (digit * power >= value * (1 - 1e-9)) return digit * power;
  }
  return 10 * power;
}

/// The largest of 1, 2, 5 times a power of ten that is not above `value`.
double round_below(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value) + 1e-12));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= value * (1 + 1e-9)) return digit * power;
  }
  return power;
}

}  // namespace

SvgAxis SvgAxis::around(const std::vector<double>& values, bool is_logarithmic, std::string label) {
  SvgAxis axis;
  axis.is_logarithmic = is_logarithmic;
  axis.label = std::move(label);
  double least = 0, greatest = 0;
  bool any = false;
  for (const double value : values) {
    if (!std::isfinite(value) || (is_logarithmic && value <= 0)) continue;
    least = any ? std::min(least, value) : value;
    greatest = any ? std::max(greatest, value) : value;
    any = true;
  }
  if (is_logarithmic) {
    axis.low = any ? round_below(least) : 1;
    axis.high = any ? round_step(greatest) : 10;
    if (axis.high <= axis.low) axis.high = 2 * axis.low;
    return axis;
  }
  if (!any || greatest <= 0) return axis;
  const double step = round_step(greatest / kTicks);
  axis.high = step * std::ceil(greatest / step * (1 - 1e-9));
  return axis;
}

std::vector<double> SvgAxis::ticks() const {
  std::vector<double> result;
  if (!is_logarithmic) {
    const double step = round_step((high - low) / kTicks);
    const double first = std::ceil(low / step - 1e-9);
    for (int i = 0; (first + i) * step <= high + 1e-9 * step; ++i) result.push_back((first + i) * step);
    return result;
  }
  const double decades = std::log10(high / low);
  const int first = static_cast<int>(std::floor(std::log10(low))), last = static_cast<int>(std::ceil(std::log10(high)));
  for (int exponent = first; exponent <= last; ++exponent) {
    const double power = std::pow(10.0, exponent);
    for (const double digit : {1.0, 2.0, 5.0}) {
      if (digit > 1 && decades > 4) continue;
      const double value = digit * power;
      if (value >= low * 0.999 && value <= high * 1.001) result.push_back(value);
    }
  }
  return result;
}

double SvgAxis::part(double value) const {
  const double part =
      is_logarithmic ? (value <= 0 ? 0 : std::log(value / low) / std::log(high / low)) : (value - low) / (high - low);
  return std::clamp(part, 0.0, 1.0);
}

SvgPlot::SvgPlot(SvgAxis x, SvgAxis y, double width, double height)
    : x_(std::move(x)), y_(std::move(y)), width_(width), height_(height) {}

double SvgPlot::px(double x) const {
  return kLeft + x_.part(x) * (width_ - kLeft - kRight);
}

double SvgPlot::py(double y) const {
  return height_ - kBottom - y_.part(y) * (height_ - kTop - kBottom);
}

void SvgPlot::rectangle(double x0, double y0, double x1, double y1, const std::string& css_class) {
  const double left = px(x0), top = py(y1);
  body_ += text_of("<rect class=\"%s\" x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\"/>\n", css_class.c_str(),
                   left, top, std::max(0.0, px(x1) - left), std::max(0.0, py(y0) - top));
}

void SvgPlot::line(const std::vector<double>& x, const std::vector<double>& y, const std::string& css_class) {
  body_ += "<polyline class=\"" + css_class + "\" points=\"";
  for (std::size_t i = 0; i < x.size(); ++i) body_ += text_of("%.2f,%.2f ", px(x[i]), py(y[i]));
  body_ += "\"/>\n";
}

void SvgPlot::dot(double x, double y, const std::string& css_class, const std::string& tip) {
  body_ += text_of("<circle class=\"%s\" cx=\"%.2f\" cy=\"%.2f\" r=\"4\"><title>", css_class.c_str(), px(x), py(y)) +
           html_escaped(tip) + "</title></circle>\n";
}

void SvgPlot::text(double x, double y, const std::string& content, const char* anchor) {
  body_ += text_of("<text class=\"text\" x=\"%.2f\" y=\"%.2f\" text-anchor=\"%s\">", px(x), py(y), anchor) +
           html_escaped(content) + "</text>\n";
}

void SvgPlot::open_group(const std::string& tip) {
  body_ += "<g><title>" + html_escaped(tip) + "</title>\n";
}

std::string SvgPlot::svg() const {
  const double bottom = height_ - kBottom, right = width_ - kRight;
  std::string grid;
  for (const double tick : y_.ticks()) {
    grid += text_of("<line class=\"grid\" x1=\"%.2f\" x2=\"%.2f\" y1=\"%.2f\" y2=\"%.2f\"/>", kLeft, right, py(tick),
                    py(tick)) +
            text_of("<text class=\"text\" x=\"%.2f\" y=\"%.2f\" text-anchor=\"end\">%s</text>\n", kLeft - 7,
                    py(tick) + 4, tick_text(tick).c_str());
  }
  for (const double tick : x_.ticks()) {
    grid += text_of("<line class=\"grid\" x1=\"%.2f\" x2=\"%.2f\" y1=\"%.2f\" y2=\"%.2f\"/>", px(tick), px(tick), kTop,
                    bottom) +
            text_of("<text class=\"text\" x=\"%.2f\" y=\"%.2f\" text-anchor=\"middle\">%s</text>\n", px(tick),
                    bottom + 17, tick_text(tick).c_str());
  }
  std::string frame =
      text_of("<line class=\"axis\" x1=\"%.2f\" x2=\"%.2f\" y1=\"%.2f\" y2=\"%.2f\"/>\n", kLeft, right, bottom, bottom);
  frame +=
      text_of("<text class=\"label\" x=\"%.2f\" y=\"%.2f\" text-anchor=\"middle\">", (kLeft + right) / 2, height_ - 7) +
      html_escaped(x_.label) + "</text>\n";
  frame += text_of("<text class=\"label\" transform=\"translate(14 %.2f) rotate(-90)\" text-anchor=\"middle\">",
                   (kTop + bottom) / 2) +
           html_escaped(y_.label) + "</text>\n";
  return text_of("<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\">\n", width_, height_) + grid + body_ + frame + "</svg>\n";
}

std::string legend_html(const std::vector<LegendEntry>& entries) {
  std::string html = "<p class=\"legend\">";
  for (const LegendEntry& entry : entries) {
    html += "<span><svg class=\"swatch\" viewBox=\"0 0 10 10\"><rect class=\"" + entry.css_class +
            "\" width=\"10\" height=\"10\"/></svg>" + html_escaped(entry.label) + "</span> ";
  }
  return html + "</p>\n";
}

std::string tick_text(double value) {
  if (std::abs(value) >= 1e6) return text_of("%gM", value * 1e-6);
  return text_of("%g", value);
}

}  // namespace foreview
