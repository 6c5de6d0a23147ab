#include <palpate/report/histogram.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include <palpate/report/markup.h>

namespace palpate {

LogHistogram::LogHistogram(const std::vector<double>& values, std::size_t bins)
    : total_(values.size()), counts_(bins) {
  constexpr double kLeastRatio = 4.0;  // least ratio of the axis ends, so that a round number is between them
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  const double widen = std::max(1.0, std::sqrt(kLeastRatio * *least / *largest));
  low_ = *least / widen;
  high_ = *largest * widen;
  const double per_log = static_cast<double>(bins) / std::log(high_ / low_);
  for (const double value : values) {
    const auto bin = static_cast<std::ptrdiff_t>(std::floor(per_log * std::log(value / low_)));
    ++counts_[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(bin, 0, std::ssize(counts_) - 1))];
  }
}

std::size_t LogHistogram::most() const { return *std::max_element(counts_.begin(), counts_.end()); }

double LogHistogram::edge(std::size_t i) const {
  return low_ * std::pow(high_ / low_, static_cast<double>(i) / static_cast<double>(bins()));
}

std::string histogram_text(const std::vector<double>& times) {
  constexpr std::size_t kBins = 12, kLongest = 50;
  const LogHistogram histogram(times, kBins);
  std::string text;
  for (std::size_t i = 0; i < kBins; ++i) {
    const std::size_t n = histogram.count(i);
    const std::size_t bar = (n * kLongest + histogram.most() - 1) / histogram.most();  // at least one '#'
    fmt::format_to(std::back_inserter(text), "{:>9.3g} to {:>8.3g} us {:>9}  {}\n", histogram.edge(i),
                   histogram.edge(i + 1), n, std::string(bar, '#'));
  }
  return text;
}

namespace {

// Geometry of the picture, in pixels.
constexpr double kSheetWidth = 860, kSheetHeight = 440;
constexpr double kPlotLeft = 70, kPlotRight = 840, kTop = 132, kPlotBottom = 380;  // of the plot area
constexpr std::size_t kBins = 77;                                                  // ten pixels each
constexpr double kMarkRow = 17;  // row height of mark names, one per row, so that close ones are legible

constexpr const char* kSheetStyle =
    "text{font:13px system-ui,'Segoe UI',Helvetica,Arial,sans-serif;fill:#333}"
    ".title{font-size:17px;font-weight:600;fill:#111}.axis{stroke:#333;fill:none}.grid{stroke:#e4e4e4}"
    ".bar{fill:#4c78a8}.mark{stroke:#b22222;stroke-dasharray:4 "
    "3}.name{fill:#b22222;stroke:#fff;stroke-width:5px;paint-order:stroke}";

/// Coordinate mapping of a plot, and the SVG drawn so far.
class Sheet {
 public:
  explicit Sheet(const LogHistogram& histogram) : histogram_(histogram) {}

  template <typename... Args>
  void draw(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
    svg_ += '\n';
  }

  void draw_bars() {
    for (std::size_t i = 0; i < histogram_.bins(); ++i) {
      if (histogram_.count(i) == 0) continue;
      const double left = x(histogram_.edge(i)), right = x(histogram_.edge(i + 1));
      // A single slow query matters most: its bar must be visible.
      const double height = std::max(1.5, kPlotBottom - y(share(histogram_.count(i))));
      draw("<rect class='bar' x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}'/>", left + 0.5,
           kPlotBottom - height, right - left - 1.0, height);
    }
  }

  void draw_shares() {
    const double step = share_step();
    for (int i = 0; i * step <= most_share(); ++i) {
      const double at = y(i * step);
      draw("<path class='grid' d='M{} {:.1f}H{}'/>", kPlotLeft, at, kPlotRight);
      draw("<text x='{}' y='{:.1f}' text-anchor='end'>{:.3g} %</text>", kPlotLeft - 8, at + 4,
           100.0 * i * step);
    }
  }

  void draw_times() {
    const double low = histogram_.edge(0), high = histogram_.edge(histogram_.bins());
    const bool fine = high / low < 300.0;  // otherwise decades suffice
    for (int decade = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, decade) <= high;
         ++decade) {
      for (int digit = 1; digit < 10; ++digit) {
        const double time = digit * std::pow(10.0, decade);
        if (time < low || time > high) continue;
        const bool named = digit == 1 || (fine && (digit == 2 || digit == 5)) || high / low < 8.0;
        draw("<path class='axis' d='M{:.1f} {}v{}'/>", x(time), kPlotBottom, named ? 6 : 3);
        if (named)
          draw("<text x='{:.1f}' y='{}' text-anchor='middle'>{:g}</text>", x(time), kPlotBottom + 21, time);
      }
    }
    draw("<path class='axis' d='M{} {}H{}'/>", kPlotLeft, kPlotBottom, kPlotRight);
    draw("<text x='{}' y='{}' text-anchor='middle'>time of one query, \u00b5s</text>",
         (kPlotLeft + kPlotRight) / 2, kPlotBottom + 45);
  }

  void draw_marks(const std::vector<Mark>& marks) {
    const auto row = [&](std::size_t i) {
      return kTop - 8.0 - kMarkRow * static_cast<double>(marks.size() - 1 - i);
    };
    for (std::size_t i = 0; i < marks.size(); ++i) {
      draw("<path class='mark' d='M{:.1f} {}V{}'/>", x(marks[i].value), row(i) - 10, kPlotBottom);
    }
    for (std::size_t i = 0; i < marks.size(); ++i) {  // on top of all lines
      const double at = x(marks[i].value);
      const bool left = at > 0.75 * kPlotRight;  // the name stays inside the picture
      draw("<text class='name' x='{:.1f}' y='{}' text-anchor='{}'>{} = {:.3g} \u00b5s</text>",
           left ? at - 5 : at + 5, row(i), left ? "end" : "start", markup_escaped(marks[i].name),
           marks[i].value);
    }
  }

  const std::string& svg() const { return svg_; }

 private:
  double share(std::size_t count) const {
    return static_cast<double>(count) / static_cast<double>(histogram_.total());
  }
  double most_share() const { return share(histogram_.most()); }

  /// Returns 1, 2 or 5 times a power of ten that gives five to ten grid lines.
  double share_step() const {
    const double rough = most_share() / 4.0;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double digit = rough / power;
    return power * (digit < 2.0 ? 1.0 : digit < 5.0 ? 2.0 : 5.0);
  }

  double x(double time) const {
    const double low = histogram_.edge(0), high = histogram_.edge(histogram_.bins());
    return kPlotLeft + (kPlotRight - kPlotLeft) * std::log(time / low) / std::log(high / low);
  }
  double y(double share) const { return kPlotBottom - (kPlotBottom - kTop) * share / most_share(); }

  const LogHistogram& histogram_;
  std::string svg_;
};

}  // namespace

std::string histogram_svg(const std::vector<double>& times, const std::vector<Mark>& marks,
                          const std::string& title, const std::string& subtitle) {
  const LogHistogram histogram(times, kBins);
  Sheet sheet(histogram);
  sheet.draw("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' height='{1}'>",
             kSheetWidth, kSheetHeight);
  sheet.draw("<title>{}</title>", markup_escaped(title));
  sheet.draw("<style>{}</style>", kSheetStyle);
  sheet.draw("<rect width='100%' height='100%' fill='#fff'/>");
  sheet.draw("<text class='title' x='{}' y='30'>{}</text>", kPlotLeft, markup_escaped(title));
  sheet.draw("<text x='{}' y='50'>{}</text>", kPlotLeft, markup_escaped(subtitle));
  sheet.draw_shares();
  sheet.draw_bars();
  sheet.draw_times();
  sheet.draw_marks(marks);
  sheet.draw("</svg>");
  return sheet.svg();
}

}  // namespace palpate
