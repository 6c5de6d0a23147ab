#include <palpate/scene/ply_decoder.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <palpate/scene/sh_color.h>

namespace palpate {
namespace {

/// The log of a sigma of zero: sigma z of a 2DGS disc.
constexpr float kLogZero = -std::numeric_limits<float>::infinity();

PlyField operator+(PlyField field, int k) {
  return static_cast<PlyField>(static_cast<std::size_t>(field) + static_cast<std::size_t>(k));
}

PlyField field_of(std::size_t material) { return kFirstMaterial + static_cast<int>(material); }

}  // namespace

PlyDecoder::PlyDecoder(const PlyElement& vertex, ByteOrder order) : order_(order) {
  std::size_t offset = 0;
  std::map<std::string, Column> by_name;
  for (const PlyProperty& property : vertex.properties) {
    const Column column{offset, property.type};
    for (std::size_t field = 0; field < kPlyFieldCount; ++field) {
      if (property.name == kPlyFieldNames[field]) columns_[field] = column;
    }
    by_name.emplace(property.name, column);
    offset += size_of(property.type);
  }
  for (auto at = by_name.find("f_rest_0"); at != by_name.end();
       at = by_name.find("f_rest_" + std::to_string(rest_.size())))
    rest_.push_back(at->second);
}

template <typename Use>
void PlyDecoder::for_each(const Column& column, const RowBlock& rows, const Use& use) const {
  const auto [offset, type] = column;
  const ByteOrder order = order_;
  with_type(type, [&, offset = offset](auto kind) {
    const char* bytes = rows.bytes + offset;
    for (std::size_t k = 0; k < rows.count; ++k, bytes += rows.stride) {
      use(k, static_cast<double>(load_as<decltype(kind)>(bytes, order)));
    }
  });
}

void PlyDecoder::size_optional(GaussianScene& chunk) const {
  if (has(kFilter)) chunk.filter_3d.resize(chunk.size());
  if (has(kRed)) chunk.color.resize(chunk.size());
}

void PlyDecoder::decode(const RowBlock& rows, GaussianScene& chunk, std::size_t at) const {
  const auto read = [&](PlyField field, const auto& number_of) {
    for_each(field, rows,
             [&](std::size_t k, double value) { number_of(at + k) = static_cast<float>(value); });
  };
  for (int i = 0; i < 3; ++i) {
    for_each(kX + i, rows, [&, origin = chunk.origin[i]](std::size_t k, double value) {
      chunk.position[at + k][i] = static_cast<float>(value - origin);
    });
    const auto scale = [&](std::size_t k) -> float& { return chunk.scale[k][i]; };
    if (has(kScale0 + i)) {
      read(kScale0 + i, scale);
    } else {
      for (std::size_t k = 0; k < rows.count; ++k) scale(at + k) = kLogZero;
    }
    if (has(kRed)) {
      for_each(kRed + i, rows, [&, channel = static_cast<std::size_t>(i)](std::size_t k, double value) {
        chunk.color[at + k][channel] = color_from_sh(value);
      });
    }
  }
  for (int i = 0; i < 4; ++i) read(kRot0 + i, [&](std::size_t k) -> float& { return chunk.rotation[k][i]; });
  read(kOpacity, [&](std::size_t k) -> float& { return chunk.opacity[k]; });
  if (has(kFilter)) read(kFilter, [&](std::size_t k) -> float& { return chunk.filter_3d[k]; });
}

void PlyDecoder::size(PlyMaterials& materials, std::size_t rows) const {
  for (std::size_t p = 0; p < kMaterialPropertyCount; ++p)
    if (has(field_of(p))) materials.values[p].resize(rows);
}

void PlyDecoder::decode(const RowBlock& rows, PlyMaterials& materials, std::size_t at) const {
  for (std::size_t p = 0; p < kMaterialPropertyCount; ++p) {
    if (!has(field_of(p))) continue;
    float* const values = materials.values[p].data() + at;
    for_each(field_of(p), rows, [&](std::size_t k, double value) { values[k] = static_cast<float>(value); });
  }
}

void PlyDecoder::decode_sh(const RowBlock& rows, int degree, float* sh) const {
  const std::size_t side = static_cast<std::size_t>(degree) + 1;
  const std::size_t of_channel = side * side - 1;  // coefficients that are wanted
  const std::size_t stored = rest_.size() / 3, width = 3 * (1 + of_channel);
  const auto read = [&](const Column& column, std::size_t place) {
    for_each(column, rows,
             [&](std::size_t k, double value) { sh[k * width + place] = static_cast<float>(value); });
  };
  for (std::size_t channel = 0; channel < 3; ++channel) {
    if (has(kRed)) read(*columns_[kRed + static_cast<int>(channel)], channel);
    for (std::size_t k = 0; k < of_channel; ++k)
      read(rest_[channel * stored + k], 3 + channel * of_channel + k);
  }
}

Eigen::Vector3d PlyDecoder::position(const char* row) const {
  const auto number = [&](PlyField field) {
    return load_number(row + columns_[field]->offset, columns_[field]->type, order_);
  };
  return {number(kX), number(kY), number(kZ)};
}

}  // namespace palpate
