#pragma once
#include <string>
#include <vector>

namespace foreview {

/// One axis of a plot, from values to pixels.
struct SvgAxis {
  double low = 0, high = 1;  ///< values at the axis's ends
  bool is_logarithmic = false;
  std::string label;
  /// Ends moved outwards to round numbers (powers of ten with 1, 2, 5 where logarithmic) around all `values`; from 0
  /// where linear. Values must be positive for a logarithmic axis; others are left out.
  [[nodiscard]] static SvgAxis around(const std::vector<double>& values, bool is_logarithmic, std::string label);
  [[nodiscard]] std::vector<double> ticks() const;
  /// 0 at the low end, 1 at the high one; cut to 0..1.
  [[nodiscard]] double part(double value) const;
};

/// A plot as inline SVG for an HTML page: frame, grid and axes, and what is drawn into it. Colours come from classes
/// that the page's style gives: "grid", "axis", "text", and those handed in.
class SvgPlot {
 public:
  SvgPlot(SvgAxis x, SvgAxis y, double width = 860, double height = 300);
  [[nodiscard]] double px(double x) const;  ///< pixels from the left
  [[nodiscard]] double py(double y) const;  ///< pixels from the top
  /// From (x0, y0) to (x1, y1), values.
  void rectangle(double x0, double y0, double x1, double y1, const std::string& css_class);
  void line(const std::vector<double>& x, const std::vector<double>& y, const std::string& css_class);
  void dot(double x, double y, const std::string& css_class, const std::string& tip = "");
  void text(double x, double y, const std::string& content, const char* anchor = "middle");
  void open_group(const std::string& tip);
  void close_group() { body_ += "</g>\n"; }
  [[nodiscard]] std::string svg() const;

 private:
  SvgAxis x_, y_;
  double width_, height_;
  std::string body_;
};

/// Coloured words under a plot.
struct LegendEntry {
  std::string css_class, label;
};
[[nodiscard]] std::string legend_html(const std::vector<LegendEntry>& entries);

/// "0.02", "5", "1200", "2.4M": short, for ticks.
[[nodiscard]] std::string tick_text(double value);

}  // namespace foreview
