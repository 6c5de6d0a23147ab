#include <palpate/scene/ply_layout.h>

#include <algorithm>

#include <palpate/base/error.h>

namespace palpate {
namespace {

bool has(const PlyElement& vertex, PlyField field) { return vertex.find(kPlyFieldNames[field]).has_value(); }

void check_present(const std::string& path, const PlyElement& vertex) {
  if (vertex.find("packed_position")) {
    throw Error(
        "{}: is a compressed .ply (property 'packed_position'), which cannot be read; convert it to plain "
        ".ply first",
        path);
  }
  for (const PlyField field : {kX, kY, kZ, kOpacity, kScale0, kScale1, kRot0, kRot1, kRot2, kRot3}) {
    if (!has(vertex, field)) {
      throw Error("{}: property '{}' of element 'vertex' is missing; it is not a Gaussian splatting scene",
                  path, kPlyFieldNames[field]);
    }
  }
}

void check_numbers(const std::string& path, const PlyElement& vertex) {
  for (const char* name : kPlyFieldNames) {
    const auto column = vertex.find(name);
    if (column && vertex.properties[*column].list_length) {
      throw Error("{}: property '{}' is a list; it must be one number", path, name);
    }
  }
}

void check_color(const std::string& path, const PlyElement& vertex) {
  if (has(vertex, kRed) != has(vertex, kGreen) || has(vertex, kRed) != has(vertex, kBlue)) {
    throw Error("{}: has some of the properties f_dc_0, f_dc_1, f_dc_2 but not all; the file is damaged",
                path);
  }
}

int find_sh_degree(const std::string& path, const PlyElement& vertex) {
  const auto is_rest = [](const PlyProperty& p) { return p.name.starts_with("f_rest_"); };
  const auto count =
      static_cast<int>(std::count_if(vertex.properties.begin(), vertex.properties.end(), is_rest));
  for (int degree = 0; degree <= 4; ++degree) {
    if (count != 3 * ((degree + 1) * (degree + 1) - 1)) continue;
    for (int k = 0; k < count; ++k) {
      if (!vertex.find("f_rest_" + std::to_string(k))) {
        throw Error("{}: property 'f_rest_{}' is missing among {} of its kind; the file is damaged", path, k,
                    count);
      }
    }
    return degree;
  }
  throw Error(
      "{}: has {} properties f_rest_*, which matches no SH degree (0, 9, 24, 45 or 72); the file is damaged",
      path, count);
}

bool is_wide(const PlyElement& vertex, PlyField field) {
  const PlyType type = vertex.properties[*vertex.find(kPlyFieldNames[field])].type;
  return type == PlyType::kFloat64 || type == PlyType::kInt32 || type == PlyType::kUint32;
}

}  // namespace

PlyLayout check_layout(const std::string& path, const PlyElement& vertex) {
  check_present(path, vertex);
  check_numbers(path, vertex);
  check_color(path, vertex);
  PlyLayout layout;
  layout.sh_degree = find_sh_degree(path, vertex);
  layout.variant = has(vertex, kFilter) ? "Mip-Splatting" : has(vertex, kScale2) ? "INRIA" : "2DGS";
  layout.wide_positions = is_wide(vertex, kX) || is_wide(vertex, kY) || is_wide(vertex, kZ);
  for (const MaterialPropertyFormat& property : kMaterialProperties)
    if (vertex.find(property.name)) layout.materials.push_back(property.name);
  return layout;
}

}  // namespace palpate
