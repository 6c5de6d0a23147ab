#include <array>
#include <optional>

#include <palpate/base/error.h>
#include <palpate/scene/ply_rows.h>

namespace palpate {
namespace {

ByteOrder byte_order(const PlyHeader& header) {
  return header.encoding == PlyEncoding::kBinaryBigEndian ? ByteOrder::kBig : ByteOrder::kLittle;
}

/// Skips elements of a binary file.
class ElementSkipper {
 public:
  ElementSkipper(const InputFile& file, const PlyHeader& header)
      : file_(file), header_(header), order_(byte_order(header)) {}

  /// Returns the byte offset after the elements begin ... end-1, whose data begin at `offset`.
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
    return Error("{}: byte {}: ends inside element '{}'; the file is truncated or its header is wrong",
                 file_.path(), file_.size(), element.name);
  }

  const InputFile& file_;
  const PlyHeader& header_;
  ByteOrder order_;
};

/// Returns the byte offset of the rows of `vertex`. \throws Error if the file does not contain them all.
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
    throw Error("{}: byte {}: ends inside Gaussian {} of {}; the file is truncated or its header is wrong",
                file.path(), file.size(), whole_rows, vertex.count);
  }
  return offset;
}

class BinaryRows final : public PlyRows {
 public:
  explicit BinaryRows(const PlyScene& ply)
      : ply_(ply), offset_(find_rows(ply)), reader_(ply.file, offset_, *ply.vertex().stride()) {}

  PlyDecoder decoder() const override { return {ply_.vertex(), byte_order(ply_.header)}; }

  void next(std::size_t n, const RowReader::Decode& decode) override {
    reader_.read(done_, n, decode);
    done_ += n;
  }

  std::uint64_t finish() override {
    const std::uint64_t end = offset_ + ply_.vertex().count * *ply_.vertex().stride();
    const ElementSkipper skipper(ply_.file, ply_.header);
    return ply_.file.size() - skipper.skip(ply_.vertex_index + 1, ply_.header.elements.size(), end);
  }

 private:
  const PlyScene& ply_;
  std::uint64_t offset_;  ///< of the first row
  RowReader reader_;
  std::uint64_t done_ = 0;  ///< rows read
};

}  // namespace

std::unique_ptr<PlyRows> open_binary_rows(const PlyScene& ply) { return std::make_unique<BinaryRows>(ply); }

}  // namespace palpate
