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
  std::optional<double> low = {}, high = {};  ///< where it ends; what is drawn decides if unset
  std::vector<std::string> categories = {};   ///< names at 0, 1, 2 ...; empty for numbers
};

/// `low` to `high` is a band around a line, or a bar through a dot. Points that are not finite, or not
/// positive on a logarithmic axis, are left out.
struct PlotPoint {
  PlotPoint(double x_, double y_) : PlotPoint(x_, y_, y_, y_) {}
  PlotPoint(double x_, double y_, double low_, double high_) : x(x_), y(y_), low(low_), high(high_) {}

  double x, y, low, high;
};

struct PlotSeries {
  enum class Style {
    kLine,
    kDots,
    kCloud,  ///< dots so small that thousands make a shape
  };
  static constexpr int kTruth = -1;  ///< a colour: neutral, and dashed
  static constexpr int kColors = 4;

  std::string name;  ///< in the legend
  Style style = Style::kLine;
  int color = 0;  ///< kTruth, or 0 ... kColors-1
  std::vector<PlotPoint> points = {};
};

/// A line across the picture, with a name at its top.
struct PlotMark {
  double x;
  std::string name;
};

struct Plot {
  std::string name;  ///< a word, unique in a page
  std::string title;
  std::string subtitle;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
  std::vector<PlotMark> marks = {};
};

/// Between the tags of <style>, once a page: plots are light or dark as the reader likes it.
std::string plot_style();

/// An <svg> for a page that has plot_style().
std::string plot_in_page(const Plot& plot);

/// A whole SVG document that needs nothing else.
std::string plot_document(const Plot& plot);

}  // namespace palpate
