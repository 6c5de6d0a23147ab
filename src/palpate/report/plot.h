/// \file
/// Small plots as SVG: lines with bands, and dots with bars, over an axis of numbers or of names.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate {

struct PlotAxis {
  std::string title;  ///< with its unit
  bool logarithmic = false;
  std::optional<double> low = {}, high = {};  ///< ends of the axis; if unset, those of the data
  std::vector<std::string> categories = {};   ///< names at 0, 1, 2 ...; empty for numbers

  static constexpr double kLeastCount = 0.5;  ///< shown for a count of 0 on a logarithmic axis
};

/// A point of a series; `low` to `high` is a band around a line, or an error bar of a dot. Points that are
/// not finite, or not positive on a logarithmic axis, are omitted.
struct PlotPoint {
  PlotPoint(double x_, double y_) : PlotPoint(x_, y_, y_, y_) {}
  PlotPoint(double x_, double y_, double low_, double high_) : x(x_), y(y_), low(low_), high(high_) {}

  double x, y, low, high;
};

struct PlotSeries {
  enum class Style {
    kLine,
    kDots,
    kCloud,  ///< dots so small that thousands form a shape
  };
  static constexpr int kTruth = -1;  ///< colour of reference curves: neutral, and dashed
  static constexpr int kColors = 4;

  std::string name;  ///< in the legend
  Style style = Style::kLine;
  int color = 0;  ///< kTruth, or 0 ... kColors-1
  std::vector<PlotPoint> points = {};
};

/// A vertical line through the plot, with a name at its top.
struct PlotMark {
  double x;
  std::string name;
};

struct Plot {
  std::string name;  ///< one word, unique in a page
  std::string title;
  std::string subtitle;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
  std::vector<PlotMark> marks = {};
};

/// Returns the contents of a <style> element, needed once per page: plots follow the reader's light or dark
/// scheme.
std::string plot_style();

/// Returns an <svg> element for a page that has plot_style().
std::string plot_in_page(const Plot& plot);

/// Returns a self-contained SVG document.
std::string plot_document(const Plot& plot);

}  // namespace palpate
