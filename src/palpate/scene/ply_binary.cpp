#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <palpate/base/error.h>
#include <palpate/scene/origin_survey.h>
#include <palpate/scene/ply_scene.h>
#include <palpate/scene/row_reader.h>

namespace palpate {
namespace {

ByteOrder byte_order(const PlyHeader& header) {
  return header.encoding == PlyEncoding::kBinaryBigEndian ? ByteOrder::kBig : ByteOrder::kLittle;
}

/// Walks over the elements of a binary file without keeping anything of them.
class ElementSkipper {
 public:
  ElementSkipper(const InputFile& file, const PlyHeader& header)
      : file_(file), header_(header), order_(byte_order(header)) {}

  /// Byte after the elements begin ... end-1, whose data begin at `offset`.
  std::uint64_t skip(std::size_t begin, std::size_t end, std::uint64_t offset) const {
    for (std::size_t i = begin; i < end; ++i) offset = skip(header_.elements[i], offset);
    return offset;
  }

 private:
  std::uint64_t skip(const PlyElement& element, std::uint64_t offset) const {
    if (const auto stride = element.stride()) {
      if (*stride != 0 && element.count > (file_.size() - offset) / *stride) throw ends_early(element);
      return offset + element.count * *stride;
    }
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (const PlyProperty& property : element.properties) offset = skip(element, property, offset);
    }
    return offset;
  }

  std::uint64_t skip(const PlyElement& element, const PlyProperty& property, std::uint64_t offset) const {
    std::uint64_t bytes = size_of(property.type);
    if (property.list_length) {
      const std::size_t head = size_of(*property.list_length);
      if (head > file_.size() - offset) throw ends_early(element);
      bytes *= list_items(property, offset);
      offset += head;
    }
    if (bytes > file_.size() - offset) throw ends_early(element);
    return offset + bytes;
  }

  std::uint64_t list_items(const PlyProperty& list, std::uint64_t offset) const {
    std::array<char, 8> raw{};
    file_.read(offset, {raw.data(), size_of(*list.list_length)});
    const double items = load_number(raw.data(), *list.list_length, order_);
    if (!(items >= 0.0 && items <= static_cast<double>(file_.size()))) {
      throw Error("{}: byte {}: list '{}' claims {} items; the file is damaged", file_.path(), offset,
                  list.name, items);
    }
    return static_cast<std::uint64_t>(items);
  }

  Error ends_early(const PlyElement& element) const {
    return Error("{}: byte {}: ends inside element '{}'; the file is cut or its header is wrong",
                 file_.path(), file_.size(), element.name);
  }

  const InputFile& file_;
  const PlyHeader& header_;
  ByteOrder order_;
};

/// Where the rows of `vertex` begin, having checked that they are all there.
std::uint64_t find_rows(const PlyScene& ply) {
  const InputFile& file = ply.file;
  const PlyElement& vertex = ply.vertex();
  const std::uint64_t offset =
      ElementSkipper(file, ply.header).skip(0, ply.vertex_index, ply.header.data_offset);
  const auto stride = vertex.stride();
  if (!stride)
    throw Error("{}: element 'vertex' has a list property; rows of one size are needed", file.path());
  const std::uint64_t whole_rows = (file.size() - offset) / *stride;
  if (vertex.count > whole_rows) {
    throw Error("{}: byte {}: ends inside Gaussian {} of {}; the file is cut or its header is wrong",
                file.path(), file.size(), whole_rows, vertex.count);
  }
  return offset;
}

/// The origin of wide positions, for which all rows are read. `offset` is where they begin.
Eigen::Vector3d find_origin(const PlyScene& ply, std::uint64_t offset, const Progress& progress) {
  const std::uint64_t count = ply.vertex().count;
  const PlyDecoder decoder(ply.vertex(), byte_order(ply.header));
  RowReader rows(ply.file, offset, *ply.vertex().stride());
  OriginSurvey survey(count);
  for (std::uint64_t first = 0; first < count; first += SceneReader::kChunk) {
    const std::size_t n = std::min<std::uint64_t>(SceneReader::kChunk, count - first);
    rows.read(first, n, [&](const RowBlock& block, std::size_t at) {
      for (std::size_t k = 0; k < block.count; ++k) {
        survey.add(first + at + k, decoder.position(block.row(k)));
      }
    });
    report(progress, kSurveyStage, static_cast<double>(first + n) / static_cast<double>(count));
  }
  return survey.origin();
}

class BinaryPlyReader final : public SceneReader {
 public:
  BinaryPlyReader(PlyScene ply, GaussianScene description, std::uint64_t offset, const Progress& progress)
      : SceneReader(std::move(description), ply.vertex().count, progress),
        ply_(std::move(ply)),
        end_(offset + count() * *ply_.vertex().stride()),
        decoder_(ply_.vertex(), byte_order(ply_.header)),
        rows_(ply_.file, offset, *ply_.vertex().stride()) {}

 private:
  void read(std::uint64_t first, GaussianScene& chunk) override {
    decoder_.size_optional(chunk);
    rows_.read(first, chunk.size(),
               [&](const RowBlock& block, std::size_t at) { decoder_.decode(block, chunk, at); });
  }

  std::uint64_t read_end() override {
    const ElementSkipper skipper(ply_.file, ply_.header);
    return ply_.file.size() - skipper.skip(ply_.vertex_index + 1, ply_.header.elements.size(), end_);
  }

  PlyScene ply_;
  std::uint64_t end_;  ///< byte after the last row
  PlyDecoder decoder_;
  RowReader rows_;
};

}  // namespace

std::unique_ptr<SceneReader> open_binary_ply(PlyScene ply, const Progress& progress) {
  const std::uint64_t offset = find_rows(ply);
  GaussianScene description = ply.describe();
  if (ply.layout.wide_positions) description.origin = find_origin(ply, offset, progress);
  return std::make_unique<BinaryPlyReader>(std::move(ply), std::move(description), offset, progress);
}

}  // namespace palpate
