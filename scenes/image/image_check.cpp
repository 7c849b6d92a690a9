#include "scenes/image/image_check.h"

#include <fmt/format.h>
#include <jerror.h>
#include <jpeglib.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <boost/crc.hpp>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scenes/base/message_text.h"

namespace pickbed::scenes {
namespace {

// ---- PNG ----

constexpr std::string_view kPngHead = "\x89PNG\r\n\x1a\n";

uint32_t BigEndian32(std::string_view bytes) {
  uint32_t number = 0;
  for (int i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}

// What a decoder needs of a PNG: size and form of the pixels, and the chunks of the data.
struct PngChunks {
  std::string_view header;
  std::vector<std::string_view> data;
};

// Returns the bytes of `width` x `height` pixels: each row begins with a byte for its filter.
uint64_t BytesOfRows(uint64_t width, uint64_t height, uint64_t bits) {
  return width == 0 ? 0 : height * (1 + (width * bits + 7) / 8);
}

// Returns the bytes of the pixels before compression (PNG, third edition, sections 7 and 8). 0 if
// the header has no valid form or more than kMaxPixels.
uint64_t PngDataBytes(std::string_view header) {
  constexpr size_t kHeader = 13;
  constexpr std::array<uint64_t, 7> kChannels{1, 0, 3, 1, 2, 0, 4};  // of the color types
  if (header.size() != kHeader) return 0;
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(header[i]); };
  const uint64_t width = BigEndian32(header), height = BigEndian32(header.substr(4));
  constexpr std::string_view kDepths("\1\2\4\10\20", 5);
  const bool is_valid = byte(9) < kChannels.size() && kChannels[byte(9)] > 0 &&
                        kDepths.find(header[8]) != std::string_view::npos && byte(10) == 0 &&
                        byte(11) == 0 && byte(12) <= 1;
  if (!is_valid || width * height > uint64_t{kMaxPixels}) return 0;
  const uint64_t bits = byte(8) * kChannels[byte(9)];
  if (byte(12) == 0) return BytesOfRows(width, height, bits);
  // Seven interlaced passes (Adam7): first column and row, and steps between them.
  constexpr uint64_t kPasses[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                      {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
  uint64_t bytes = 0;
  for (const auto& [x, y, step_x, step_y] : kPasses) {
    const uint64_t columns = width > x ? (width - x + step_x - 1) / step_x : 0;
    const uint64_t rows = height > y ? (height - y + step_y - 1) / step_y : 0;
    bytes += BytesOfRows(columns, rows, bits);
  }
  return bytes;
}

// Returns the number of bytes of the decompressed chunks, and stops above `limit`. nullopt if they
// are damaged.
std::optional<uint64_t> DecompressedBytes(const std::vector<std::string_view>& chunks,
                                          uint64_t limit) {
  std::vector<unsigned char> buffer(1 << 16);
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return std::nullopt;
  uint64_t bytes = 0;
  int state = Z_OK;
  for (const std::string_view chunk : chunks) {
    stream.next_in = reinterpret_cast<unsigned char*>(const_cast<char*>(chunk.data()));
    stream.avail_in = static_cast<unsigned>(chunk.size());
    do {
      stream.next_out = buffer.data();
      stream.avail_out = static_cast<unsigned>(buffer.size());
      state = inflate(&stream, Z_NO_FLUSH);
      bytes += buffer.size() - stream.avail_out;
    } while (state == Z_OK && stream.avail_out == 0 && bytes <= limit);
    if ((state != Z_OK && state != Z_BUF_ERROR) || bytes > limit) break;
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END && bytes <= limit) return std::nullopt;
  return bytes;
}

// The fault of data that does not fit the header. Decoders leave out rows, or add them.
std::string FaultOfPngData(const PngChunks& chunks) {
  const uint64_t expected = PngDataBytes(chunks.header);
  if (expected == 0) return "the PNG has a damaged header, or more than 67 million pixels";
  const std::optional<uint64_t> bytes = DecompressedBytes(chunks.data, expected);
  if (!bytes) return "the PNG has damaged or missing data";
  if (*bytes == expected) return "";
  return fmt::format("the PNG has {} data than the {} x {} pixels of its header",
                     *bytes < expected ? "less" : "more", BigEndian32(chunks.header),
                     BigEndian32(chunks.header.substr(4)));
}

std::string FaultOfPng(std::string_view bytes) {
  constexpr size_t kFrame = 12;  // bytes of a chunk without its content: size, name, check sum
  if (!bytes.starts_with(kPngHead)) return "the PNG has a damaged head";
  PngChunks chunks;
  for (std::string_view rest = bytes.substr(kPngHead.size());;) {
    if (rest.size() < kFrame) return "the PNG is cut short";
    const uint32_t size = BigEndian32(rest);
    if (size > rest.size() - kFrame) return "the PNG is cut short";
    const std::string_view checked = rest.substr(4, 4 + size);
    const std::string_view name = checked.substr(0, 4);
    if (BigEndian32(rest.substr(8 + size)) != PngCheckSum(checked)) {
      return fmt::format("the PNG is damaged: the check sum of its chunk '{}' is wrong",
                         OneLine(std::string(name)));
    }
    if (name == "IHDR" && chunks.header.empty()) chunks.header = checked.substr(4);
    if (name == "IDAT") chunks.data.push_back(checked.substr(4));
    rest.remove_prefix(kFrame + size);
    if (name != "IEND") continue;
    if (rest.empty()) return FaultOfPngData(chunks);
    return fmt::format("the PNG has {} bytes after its end", rest.size());
  }
}

// ---- JPEG ----

// The library calls these functions with a pointer to the first member.
struct JpegErrors {
  jpeg_error_mgr manager;
  std::jmp_buf on_error;
  char text[JMSG_LENGTH_MAX];  // the first warning or error; empty = none
};

void KeepText(j_common_ptr codec) {
  auto& errors = *reinterpret_cast<JpegErrors*>(codec->err);
  if (errors.text[0] == 0) codec->err->format_message(codec, errors.text);
}

// The library must not return from an error.
void LeaveOnError(j_common_ptr codec) {
  KeepText(codec);
  std::longjmp(reinterpret_cast<JpegErrors*>(codec->err)->on_error, 1);
}

// Some cameras write a few bytes more before the end mark. Many bytes are left if the codes are
// damaged.
void KeepWarning(j_common_ptr codec, int level) {
  constexpr int kMaxFillBytes = 16, kEndMark = 0xd9;
  const jpeg_error_mgr& error = *codec->err;
  if (level >= 0) return;
  if (error.msg_code == JWRN_EXTRANEOUS_DATA && error.msg_parm.i[0] <= kMaxFillBytes &&
      error.msg_parm.i[1] == kEndMark) {
    return;
  }
  KeepText(codec);
}

// Decodes at an eighth of the size, which reads all of the data. It has no objects with
// destructors, because an error leaves it by longjmp.
void DecodeSmall(const unsigned char* bytes, size_t size, jpeg_decompress_struct& codec,
                 JpegErrors& errors) {
  if (setjmp(errors.on_error) != 0) return;
  jpeg_create_decompress(&codec);
  jpeg_mem_src(&codec, bytes, size);
  jpeg_read_header(&codec, TRUE);
  codec.scale_num = 1;
  codec.scale_denom = 8;
  jpeg_start_decompress(&codec);
  const JDIMENSION width = codec.output_width * static_cast<JDIMENSION>(codec.output_components);
  const JSAMPARRAY row =
      codec.mem->alloc_sarray(reinterpret_cast<j_common_ptr>(&codec), JPOOL_IMAGE, width, 1);
  while (codec.output_scanline < codec.output_height) jpeg_read_scanlines(&codec, row, 1);
  jpeg_finish_decompress(&codec);
}

std::span<const UINT8> SymbolsOf(const JHUFF_TBL& table) {
  constexpr int kMaxLength = 16, kSymbols = 256;
  const int count = std::accumulate(table.bits + 1, table.bits + 1 + kMaxLength, 0);
  return {table.huffval, static_cast<size_t>(std::min(count, kSymbols))};
}

// Each symbol of a table has one code. Encoders write no symbol twice.
bool HasSymbolTwice(const JHUFF_TBL& table) {
  std::array<bool, 256> seen{};
  for (const UINT8 symbol : SymbolsOf(table)) {
    if (std::exchange(seen[symbol], true)) return true;
  }
  return false;
}

// Whether a table of an image of 8 bits can have the symbol (ITU T.81, sections F.1.2 and G.1.2).
// It is a number of bits. In a table for AC coefficients, its upper half is a run of zeros.
bool CanBeSymbol(int symbol, bool is_ac, const jpeg_decompress_struct& codec) {
  constexpr int kMaxDcBits = 11, kMaxAcBits = 10, kSixteenZeros = 0xf0;
  if (!is_ac) return symbol <= kMaxDcBits;
  const int bits = symbol & 0xf;
  // In a progressive image, a symbol of no bits ends several blocks.
  const bool may_be_end = codec.progressive_mode || symbol == 0 || symbol == kSixteenZeros;
  return bits <= kMaxAcBits && (bits > 0 || may_be_end);
}

// Returns the fault of the symbols of a table; empty = none.
std::string FaultOfTable(const JHUFF_TBL& table, bool is_ac, const jpeg_decompress_struct& codec) {
  if (HasSymbolTwice(table)) return "has a symbol twice";
  for (const UINT8 symbol : SymbolsOf(table)) {
    if (CanBeSymbol(symbol, is_ac, codec)) continue;
    return fmt::format("has the symbol {:#04x}, which is none", symbol);
  }
  return "";
}

std::string FaultOfTables(const jpeg_decompress_struct& codec) {
  for (int i = 0; i < NUM_HUFF_TBLS; ++i) {
    for (const bool is_ac : {false, true}) {
      const JHUFF_TBL* const table = is_ac ? codec.ac_huff_tbl_ptrs[i] : codec.dc_huff_tbl_ptrs[i];
      if (table == nullptr) continue;
      std::string fault = FaultOfTable(*table, is_ac, codec);
      if (!fault.empty()) return fault;
    }
  }
  return "";
}

std::string FaultOfJpeg(std::string_view bytes) {
  jpeg_decompress_struct codec{};
  JpegErrors errors{};
  codec.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = LeaveOnError;
  errors.manager.emit_message = KeepWarning;
  DecodeSmall(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), codec, errors);
  // The library refuses images of more than 8 bits, whose tables have other symbols.
  const std::string table = codec.data_precision == 8 ? FaultOfTables(codec) : "";
  jpeg_destroy_decompress(&codec);
  if (!table.empty()) return "the JPEG is damaged: a table of codes " + table;
  if (errors.text[0] == 0) return "";
  return fmt::format("the JPEG is damaged: {}", OneLine(errors.text));
}

// ---- OpenEXR ----

constexpr std::string_view kExrHead("\x76\x2f\x31\x01", 4);

// Type of an attribute, and the bytes of its value; 0 = any.
struct ExrType {
  std::string_view name;
  uint32_t bytes;
};

// The attributes that each file has (OpenEXR, "OpenEXR File Layout"). The library takes its
// defaults for the ones that are missing, and ignores the sizes of some.
const std::map<std::string_view, ExrType>& ExrAttributes() {
  static const std::map<std::string_view, ExrType> kAttributes = {
      {"channels", {"chlist", 0}},        {"compression", {"compression", 1}},
      {"dataWindow", {"box2i", 16}},      {"displayWindow", {"box2i", 16}},
      {"lineOrder", {"lineOrder", 1}},    {"pixelAspectRatio", {"float", 4}},
      {"screenWindowCenter", {"v2f", 8}}, {"screenWindowWidth", {"float", 4}}};
  return kAttributes;
}

std::string FaultOfExr(std::string_view bytes) {
  constexpr size_t kVersion = 8;      // bytes up to the first attribute
  constexpr int kOtherHeader = 0x18;  // several images or deep pixels
  const std::string no_end = "the EXR has a header without end";
  if (bytes.size() < kVersion) return no_end;
  if ((bytes[5] & kOtherHeader) != 0) return "";
  std::set<std::string_view> found;
  for (std::string_view rest = bytes.substr(kVersion);;) {
    const size_t name_end = rest.find('\0');
    if (name_end == 0) break;
    const size_t type_end = name_end < rest.size() ? rest.find('\0', name_end + 1) : rest.npos;
    uint32_t size = 0;
    if (type_end > rest.size() || rest.size() - type_end <= sizeof size) return no_end;
    std::memcpy(&size, rest.data() + type_end + 1, sizeof size);
    const std::string_view name = rest.substr(0, name_end);
    const std::string_view type = rest.substr(name_end + 1, type_end - name_end - 1);
    rest.remove_prefix(type_end + 1 + sizeof size);
    const auto known = ExrAttributes().find(name);
    const bool is_damaged =
        known != ExrAttributes().end() &&
        (known->second.name != type || (known->second.bytes != 0 && known->second.bytes != size));
    if (is_damaged || size > rest.size()) {
      return fmt::format(
          "the EXR has the attribute '{}' of type '{}' with {} bytes, so its header is damaged",
          OneLine(std::string(name)), OneLine(std::string(type)), size);
    }
    found.insert(name);
    rest.remove_prefix(size);
  }
  for (const auto& [name, type] : ExrAttributes()) {
    // Some programs leave it out if it is 1.
    if (name == "pixelAspectRatio") continue;
    if (!found.contains(name)) return fmt::format("the EXR has no attribute '{}'", name);
  }
  return "";
}

// ---- TIFF ----

bool IsTiff(std::string_view bytes) {
  return bytes.starts_with(std::string_view("II*\0", 4)) ||
         bytes.starts_with(std::string_view("MM\0*", 4));
}

// The directories of the images are a chain (TIFF 6.0, section 2). The library reads the first one
// and ignores a broken rest, which a damaged or cut file has.
std::string FaultOfTiff(std::string_view bytes) {
  constexpr size_t kFirst = 4, kCount = 2, kEntry = 12, kOffset = 4;
  const bool is_little_endian = bytes.front() == 'I';
  const auto number_at = [&](size_t at, size_t size) {
    size_t number = 0;
    for (size_t i = 0; i < size; ++i) {
      const size_t byte = is_little_endian ? size - 1 - i : i;
      number = number << 8 | static_cast<unsigned char>(bytes[at + byte]);
    }
    return number;
  };
  std::set<size_t> seen;
  for (size_t next = kFirst; next + kOffset <= bytes.size();) {
    const size_t directory = number_at(next, kOffset);
    if (directory == 0 && next != kFirst) return "";
    if (directory + kCount > bytes.size() || !seen.insert(directory).second) break;
    next = directory + kCount + kEntry * number_at(directory, kCount);
  }
  return "the TIFF has a directory that is not within the file";
}

}  // namespace

uint32_t PngCheckSum(std::string_view bytes) {
  boost::crc_32_type sum;
  sum.process_bytes(bytes.data(), bytes.size());
  return sum.checksum();
}

bool IsPng(std::string_view bytes) { return bytes.starts_with(kPngHead.substr(0, 4)); }

bool IsJpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8"); }

std::string FaultOfImage(std::string_view bytes) {
  if (IsPng(bytes)) return FaultOfPng(bytes);
  if (IsJpeg(bytes)) return FaultOfJpeg(bytes);
  if (bytes.starts_with(kExrHead)) return FaultOfExr(bytes);
  if (IsTiff(bytes)) return FaultOfTiff(bytes);
  return "";
}

}  // namespace pickbed::scenes
