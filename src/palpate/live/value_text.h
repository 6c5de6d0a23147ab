/// \file
/// Parsing of values from the command line or a configuration file.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include <palpate/device/simulated_device.h>

namespace palpate {

/// Thrown for a value that a setting does not accept; what() says why, without the setting's name.
class BadValue : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// \throws BadValue.
/// @{
double parse_number(std::string_view text);      ///< finite
double parse_positive(const std::string& text);  ///< finite and above zero
/// "1,2,3": between `min_count` and `max_count` finite numbers.
std::vector<double> parse_numbers(std::string_view text, std::size_t min_count, std::size_t max_count);
Eigen::Quaterniond parse_quaternion(const double* wxyz);  ///< normalized
HandProperties parse_hand(const double* mbk);             ///< kg, N s/m and N/m, none below zero
/// @}

}  // namespace palpate
