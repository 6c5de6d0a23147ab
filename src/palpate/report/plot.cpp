#include <palpate/report/plot.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <palpate/report/markup.h>

namespace palpate {
namespace {

// Geometry of the picture, in pixels: at this width, text is legible on a phone.
constexpr double kWidth = 480, kHeight = 340;
constexpr double kLeft = 50, kRight = 466, kBottom = 290;
constexpr double kTitle = 22, kSubtitle = 41, kLegend = 64, kLegendRow = 19;  // baselines
constexpr double kCharacter = 7.2;                                            // mean width, estimated
constexpr double kInset = 0.5;  // margin before the first and after the last category

constexpr const char* kStyle = R"(
.plot{--ink:#1b2430;--muted:#576373;--grid:#e4e8ed;--back:#fff;--c0:#2763cf;--c1:#c8451b;--c2:#0f7f5c;--c3:#8a3fb0}
@media screen and (prefers-color-scheme:dark){.plot{--ink:#e4e9f0;--muted:#98a5b5;--grid:#29323d;--back:#161b22;
--c0:#74a7ff;--c1:#ff8f66;--c2:#3ec99a;--c3:#d79bff}}
.plot text{font:13px system-ui,-apple-system,'Segoe UI',Helvetica,Arial,sans-serif;fill:var(--muted)}
.plot .title{font-size:15px;font-weight:650;fill:var(--ink)}.plot .name{fill:var(--ink)}
.plot .back{fill:var(--back)}.plot .grid{stroke:var(--grid);fill:none}.plot .axis{stroke:var(--muted);fill:none}
.plot .line{stroke:var(--c);stroke-width:2;fill:none;stroke-linejoin:round}.plot .band{fill:var(--c);opacity:.16}
.plot .mark{stroke:var(--muted);stroke-dasharray:2 3;fill:none}.plot .cloud{fill:var(--muted);opacity:.35}
.plot .dot{fill:var(--c)}.plot .bar{stroke:var(--c);stroke-width:2;opacity:.6}
.plot .truth .line{stroke:var(--muted);stroke-dasharray:6 4;stroke-width:1.5}
)";

struct Tick {
  double at;
  std::string name;
};

/// Maps the values of one axis to pixels.
class Scale {
 public:
  /// \param from,to in pixels.
  Scale(const PlotAxis& axis, double low, double high, double from, double to)
      : axis_(axis), from_(from), to_(to), low_(low), high_(high) {}

  double operator()(double value) const {
    const double share =
        axis_.logarithmic ? std::log(value / low_) / std::log(high_ / low_) : (value - low_) / (high_ - low_);
    return from_ + share * (to_ - from_);
  }

  bool can_show(double value) const { return std::isfinite(value) && (!axis_.logarithmic || value > 0.0); }

  std::vector<Tick> ticks() const {
    if (!axis_.categories.empty()) return categories();
    return axis_.logarithmic ? decades() : steps();
  }

 private:
  std::vector<Tick> categories() const {
    std::vector<Tick> ticks;
    for (std::size_t i = 0; i < axis_.categories.size(); ++i)
      ticks.push_back({static_cast<double>(i), axis_.categories[i]});
    return ticks;
  }

  /// Label of a power of ten times a digit, in few characters: 2M, 20k, 0.05, 1e-5.
  static std::string decade_text(double value) {
    if (value >= 999e3) return fmt::format("{:.3g}M", value / 1e6);
    if (value >= 999.0) return fmt::format("{:.3g}k", value / 1000.0);
    if (value > 0.00099) return fmt::format("{:.3g}", value);
    const double power = std::floor(std::log10(value) + 1e-9);
    return fmt::format("{:.3g}e{:.0f}", value / std::pow(10.0, power), power);
  }

  /// Ticks at 1, 2 and 5 times powers of ten; at powers of ten only where there are many.
  std::vector<Tick> decades() const {
    std::vector<Tick> ticks;
    const bool few = high_ / low_ > 2000.0;
    for (int decade = static_cast<int>(std::floor(std::log10(low_))); std::pow(10.0, decade) <= high_;
         ++decade) {
      for (const double digit : {1.0, 2.0, 5.0}) {
        const double at = digit * std::pow(10.0, decade);
        if (at >= 0.999 * low_ && at <= 1.001 * high_ && (digit == 1.0 || !few))
          ticks.push_back({at, decade_text(at)});
      }
    }
    return ticks;
  }

  /// Ticks that are 1, 2 or 5 times a power of ten apart.
  std::vector<Tick> steps() const {
    constexpr double kWanted = 5.0;
    const double rough = (high_ - low_) / kWanted, power = std::pow(10.0, std::floor(std::log10(rough)));
    const double digit = rough / power, step = power * (digit < 1.5   ? 1.0
                                                        : digit < 3.5 ? 2.0
                                                        : digit < 7.5 ? 5.0
                                                                      : 10.0);
    std::vector<Tick> ticks;
    const auto first = static_cast<long>(std::ceil(low_ / step - 1e-9));
    for (long k = first; static_cast<double>(k) * step <= high_ + 1e-9 * step; ++k)
      ticks.push_back({static_cast<double>(k) * step, fmt::format("{:.6g}", static_cast<double>(k) * step)});
    return ticks;
  }

  const PlotAxis& axis_;
  double from_, to_, low_, high_;
};

/// Ends of an axis; where it sets none, those of all that is drawn, with a margin.
std::pair<double, double> ends_of(const PlotAxis& axis, const std::vector<double>& values) {
  if (!axis.categories.empty()) return {-kInset, static_cast<double>(axis.categories.size()) - 1.0 + kInset};
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double v : values) {
    if (!std::isfinite(v) || (axis.logarithmic && !(v > 0.0))) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (!(low <= high)) low = high = 1.0;
  if (axis.logarithmic) {
    low = axis.low.value_or(low / 1.2);
    return {low, std::max(axis.high.value_or(high * 1.2), 1.5 * low)};
  }
  const double room = low < high ? 0.04 * (high - low) : 0.5 * std::max(1e-12, std::abs(low));
  low = axis.low.value_or(low - room);
  return {low, std::max(axis.high.value_or(high + room), low + 1e-12)};
}

/// Coordinate mapping of a plot, and the SVG drawn so far.
class Picture {
 public:
  explicit Picture(const Plot& plot)
      : plot_(plot),
        top_(kLegend + kLegendRow * static_cast<double>(legend_rows()) + 16.0),
        x_(scale(plot.x, &Picture::all_x, kLeft, kRight)),
        y_(scale(plot.y, &Picture::all_y, kBottom, top_)) {}

  std::string draw(const std::string& style) {
    put("<svg xmlns='http://www.w3.org/2000/svg' class='plot' role='img' viewBox='0 0 {0} {1}' width='{0}' "
        "height='{1}'>",
        kWidth, kHeight);
    put("<title>{}</title>", markup_escaped(plot_.title));
    if (!style.empty()) put("<style>{}</style>", style);
    put("<rect class='back' width='100%' height='100%'/>");
    put("<text class='title' x='12' y='{}'>{}</text>", kTitle, markup_escaped(plot_.title));
    put("<text x='12' y='{}'>{}</text>", kSubtitle, markup_escaped(plot_.subtitle));
    draw_legend();
    draw_axes();
    put("<clipPath id='clip-{}'><rect x='{}' y='{}' width='{}' height='{}'/></clipPath>", plot_.name, kLeft,
        top_, kRight - kLeft, kBottom - top_);
    put("<g clip-path='url(#clip-{})'>", plot_.name);
    for (const PlotSeries& s : plot_.series) draw_series(s);
    put("</g>");
    draw_marks();
    put("</svg>");
    return std::move(svg_);
  }

 private:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
    svg_ += '\n';
  }

  static void all_x(const PlotPoint& p, std::vector<double>& values) { values.push_back(p.x); }
  static void all_y(const PlotPoint& p, std::vector<double>& values) {
    values.insert(values.end(), {p.y, p.low, p.high});
  }

  Scale scale(const PlotAxis& axis, void (*take)(const PlotPoint&, std::vector<double>&), double from,
              double to) const {
    std::vector<double> values;
    for (const PlotSeries& s : plot_.series) {
      for (const PlotPoint& p : s.points) take(p, values);
    }
    const auto [low, high] = ends_of(axis, values);
    return {axis, low, high, from, to};
  }

  static std::string opened(const PlotSeries& s) {
    return s.color == PlotSeries::kTruth ? std::string("<g class='truth' style='--c:var(--muted)'>")
                                         : fmt::format("<g style='--c:var(--c{})'>", s.color);
  }

  static double legend_width(const PlotSeries& s) {
    return 40.0 + kCharacter * static_cast<double>(s.name.size());
  }

  /// Calls `visit(series, x, row)` for each series that has a name.
  template <class Visit>
  void lay_legend(const Visit& visit) const {
    double x = 12.0;
    int row = 0;
    for (const PlotSeries& s : plot_.series) {
      if (s.name.empty()) continue;
      if (x > 12.0 && x + legend_width(s) > kRight) {
        x = 12.0;
        ++row;
      }
      visit(s, x, row);
      x += legend_width(s);
    }
  }

  int legend_rows() const {
    int rows = 0;
    lay_legend([&](const PlotSeries&, double, int row) { rows = row + 1; });
    return rows;
  }

  void draw_legend() {
    lay_legend([this](const PlotSeries& s, double x, int row) {
      const double y = kLegend + kLegendRow * row;
      svg_ += opened(s);
      if (s.style == PlotSeries::Style::kDots) {
        put("<circle class='dot' cx='{:.1f}' cy='{}' r='4.5'/>", x + 10.0, y - 4.5);
      } else {
        put("<path class='line' d='M{:.1f} {}h20'/>", x, y - 4.5);
      }
      put("<text class='name' x='{:.1f}' y='{}'>{}</text></g>", x + 26.0, y, markup_escaped(s.name));
    });
  }

  void draw_axes() {
    for (const Tick& tick : y_.ticks()) {
      const double at = y_(tick.at);
      put("<path class='grid' d='M{} {:.1f}H{}'/>", kLeft, at, kRight);
      put("<text x='{}' y='{:.1f}' text-anchor='end'>{}</text>", kLeft - 7, at + 4.5,
          markup_escaped(tick.name));
    }
    for (const Tick& tick : x_.ticks()) {
      const double at = x_(tick.at);
      put("<path class='axis' d='M{:.1f} {}v5'/>", at, kBottom);
      put("<text x='{:.1f}' y='{}' text-anchor='middle'>{}</text>", at, kBottom + 19,
          markup_escaped(tick.name));
    }
    put("<path class='axis' d='M{} {}H{}'/>", kLeft, kBottom, kRight);
    put("<text x='12' y='{}'>{}</text>", top_ - 12.0, markup_escaped(plot_.y.title));
    put("<text x='{}' y='{}' text-anchor='end'>{}</text>", kRight, kBottom + 41,
        markup_escaped(plot_.x.title));
  }

  void draw_marks() {
    for (const PlotMark& mark : plot_.marks) {
      if (!x_.can_show(mark.x)) continue;
      const double at = x_(mark.x);
      put("<path class='mark' d='M{:.1f} {:.1f}V{}'/>", at, top_, kBottom);
      put("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>", at, top_ - 1.0,
          markup_escaped(mark.name));
    }
  }

  bool can_show(const PlotPoint& p) const {
    return x_.can_show(p.x) && y_.can_show(p.y) && y_.can_show(p.low) && y_.can_show(p.high);
  }

  void draw_series(const PlotSeries& s) {
    std::vector<PlotPoint> points;
    std::copy_if(s.points.begin(), s.points.end(), std::back_inserter(points),
                 [this](const PlotPoint& p) { return can_show(p); });
    if (points.empty()) return;
    svg_ += opened(s);
    switch (s.style) {
      case PlotSeries::Style::kDots: draw_dots(points); break;
      case PlotSeries::Style::kCloud: draw_cloud(points); break;
      default: draw_line(points);
    }
    put("</g>");
  }

  void draw_dots(const std::vector<PlotPoint>& points) {
    for (const PlotPoint& p : points) {
      const double x = x_(p.x);
      if (p.low < p.high) put("<path class='bar' d='M{:.1f} {:.1f}V{:.1f}'/>", x, y_(p.low), y_(p.high));
      put("<circle class='dot' cx='{:.1f}' cy='{:.1f}' r='4.5'/>", x, y_(p.y));
    }
  }

  void draw_cloud(const std::vector<PlotPoint>& points) {
    for (const PlotPoint& p : points)
      put("<circle class='cloud' cx='{:.1f}' cy='{:.1f}' r='0.9'/>", x_(p.x), y_(p.y));
  }

  void draw_line(const std::vector<PlotPoint>& points) {
    const bool band =
        std::any_of(points.begin(), points.end(), [](const PlotPoint& p) { return p.low < p.high; });
    if (band) {
      std::string d;
      for (const PlotPoint& p : points) append(d, p.x, p.high);
      for (auto p = points.rbegin(); p != points.rend(); ++p) append(d, p->x, p->low);
      put("<path class='band' d='{}Z'/>", d);
    }
    std::string d;
    for (const PlotPoint& p : points) append(d, p.x, p.y);
    put("<path class='line' d='{}'/>", d);
  }

  void append(std::string& path, double x, double y) const {
    fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_(x), y_(y));
  }

  const Plot& plot_;
  double top_;
  Scale x_, y_;
  std::string svg_;
};

}  // namespace

std::string plot_style() { return kStyle; }
std::string plot_in_page(const Plot& plot) { return Picture(plot).draw(""); }
std::string plot_document(const Plot& plot) { return Picture(plot).draw(kStyle); }

}  // namespace palpate
