#include <palpate/live/value_text.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <palpate/geometry/unit_quaternion.h>

namespace palpate {

double parse_number(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), value);
  if (text.empty() || error != std::errc{} || end != text.end() || !std::isfinite(value)) {
    throw BadValue(fmt::format("'{}' is not a finite number", text));
  }
  return value;
}

double parse_positive(const std::string& text) {
  const double value = parse_number(text);
  if (!(value > 0.0)) throw BadValue(text + " is not positive");
  return value;
}

std::vector<double> parse_numbers(std::string_view text, std::size_t min_count, std::size_t max_count) {
  std::vector<double> numbers;
  std::string_view rest = text;
  for (;;) {
    const std::size_t comma = rest.find(',');
    numbers.push_back(parse_number(rest.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (numbers.size() < min_count || numbers.size() > max_count) {
    throw BadValue(fmt::format("'{}' has {} numbers; {} are needed", text, numbers.size(), min_count));
  }
  return numbers;
}

Eigen::Quaterniond parse_quaternion(const double* wxyz) {
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!(q.norm() > 1e-6 && q.norm() < 1e6)) {
    throw BadValue("the quaternion qw,qx,qy,qz must have a norm between 1e-6 and 1e6");
  }
  return normalized_once(q);
}

HandProperties parse_hand(const double* mbk) {
  if (std::any_of(mbk, mbk + 3, [](double v) { return v < 0.0; }))
    throw BadValue("mass, damping and stiffness must not be negative");
  return {mbk[0], mbk[1], mbk[2]};
}

}  // namespace palpate
