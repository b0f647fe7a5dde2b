#include "Text/WordPiece.h"

#include "Core/Base/Error.h"
#include "Core/Base/PathText.h"
#include "Text/Unicode.h"

#include <fstream>

namespace innergs {
namespace {

constexpr std::size_t kLongestWord = 100; // code points; longer ones are unknown, as in BERT

bool isSpace(char32_t c) {
  return c == ' ' || (c >= '\t' && c <= '\r') || c == 0xa0 || c == 0x1680 || (c >= 0x2000 && c <= 0x200a) ||
         c == 0x2028 || c == 0x2029 || c == 0x202f || c == 0x205f || c == 0x3000;
}

/// What is dropped: control and format characters, combining accents, invalid characters.
bool isNothing(char32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0xad || (c >= 0x300 && c < 0x370) || c == 0xfffd ||
         (c >= 0x200b && c <= 0x200f) || (c >= 0x202a && c <= 0x202e) || c == 0xfeff;
}

bool isPunctuation(char32_t c) {
  return (c >= 33 && c <= 47) || (c >= 58 && c <= 64) || (c >= 91 && c <= 96) || (c >= 123 && c <= 126) ||
         c == 0xa1 || c == 0xa7 || c == 0xab || c == 0xb6 || c == 0xb7 || c == 0xbb || c == 0xbf ||
         (c >= 0x2010 && c <= 0x2027) || (c >= 0x2030 && c <= 0x205e && c != 0x2044 && c != 0x2052) ||
         (c >= 0x3001 && c <= 0x3003) || (c >= 0x3008 && c <= 0x3011);
}

/// Chinese characters are words of their own.
bool isIdeograph(char32_t c) {
  return (c >= 0x4e00 && c <= 0x9fff) || (c >= 0x3400 && c <= 0x4dbf) || (c >= 0xf900 && c <= 0xfaff) ||
         (c >= 0x20000 && c <= 0x2fa1f);
}

/// Letters that no accent makes, which therefore keep their form.
bool isOwnLetter(char32_t c) {
  for (const char32_t own :
       {0xf0, 0xf8, 0xfe, 0x111, 0x127, 0x131, 0x138, 0x140, 0x142, 0x149, 0x14b, 0x167, 0x17f})
    if (c == own) return true;
  return false;
}

char32_t lower(char32_t c) {
  if (c == 0x130) return 'i'; // the Turkish I with a dot
  if (c == 0x1e9e) return 0xdf;
  if ((c >= 'A' && c <= 'Z') || (c >= 0xc0 && c <= 0xde && c != 0xd7) || (c >= 0x391 && c <= 0x3a9) ||
      (c >= 0x410 && c <= 0x42f))
    return c + 0x20;
  if (c >= 0x400 && c <= 0x40f) return c + 0x50;
  const bool evenIsUpper = (c >= 0x100 && c <= 0x137) || (c >= 0x14a && c <= 0x177);
  const bool oddIsUpper = (c >= 0x139 && c <= 0x148) || (c >= 0x179 && c <= 0x17e);
  if ((evenIsUpper && c % 2 == 0) || (oddIsUpper && c % 2 == 1)) return c + 1;
  return c == 0x178 ? 0xff : c;
}

std::size_t codePoints(const std::string& word) {
  std::size_t count = 0;
  for (const char byte : word)
    count += (static_cast<unsigned char>(byte) & 0xc0) != 0x80;
  return count;
}

} // namespace

WordPiece::WordPiece(const std::filesystem::path& vocabulary) {
  const std::string name = "'" + utf8(vocabulary) + "'";
  std::ifstream in(vocabulary, std::ios::binary);
  if (!in)
    throw Error(ErrorCode::FileNotFound,
                "There is no vocabulary " + name + ": give the vocab.txt that belongs to the network.");
  std::int64_t number = 0;
  for (std::string line; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    pieces_.emplace(line, number);
  }
  unknown_ = numberOf("[UNK]");
  first_ = numberOf("[CLS]");
  last_ = numberOf("[SEP]");
  if (unknown_ < 0 || first_ < 0 || last_ < 0)
    throw Error(ErrorCode::FileFormat,
                name +
                    " is no WordPiece vocabulary, a line for every piece with [UNK], [CLS] and [SEP] among "
                    "them: give the vocab.txt that belongs to the network.");
}

std::int64_t WordPiece::numberOf(const std::string& piece) const {
  const auto found = pieces_.find(piece);
  return found == pieces_.end() ? -1 : found->second;
}

void WordPiece::addPieces(const std::string& word, std::vector<std::int64_t>& numbers) const {
  const std::size_t before = numbers.size();
  std::size_t begin = codePoints(word) > kLongestWord ? std::string::npos : 0;
  while (begin < word.size()) {
    std::size_t end = word.size();
    std::int64_t number = -1;
    for (; end > begin; --end) {
      if (end < word.size() && (static_cast<unsigned char>(word[end]) & 0xc0) == 0x80) continue;
      number = numberOf((begin > 0 ? "##" : "") + word.substr(begin, end - begin));
      if (number >= 0) break;
    }
    if (number < 0) {
      begin = std::string::npos;
      break;
    }
    numbers.push_back(number);
    begin = end;
  }
  if (begin == std::string::npos) { // a word is known as a whole or not at all
    numbers.resize(before);
    numbers.push_back(unknown_);
  }
}

std::vector<std::int64_t> WordPiece::numbersOf(std::string_view text, std::size_t longest) const {
  std::vector<std::int64_t> numbers{first_};
  std::string word;
  const auto end = [&] {
    if (!word.empty()) addPieces(word, numbers);
    word.clear();
  };
  for (std::size_t at = 0; at < text.size();) {
    const char32_t c = lower(nextCodePoint(text, at));
    if (isSpace(c)) {
      end();
    } else if (isNothing(c)) {
      continue;
    } else if (isPunctuation(c) || isIdeograph(c)) {
      end();
      appendUtf8(word, c);
      end();
    } else {
      const std::string letter = isOwnLetter(c) ? std::string() : withoutAccent(c);
      if (letter.size() == 1)
        word += letter;
      else
        appendUtf8(word, c);
    }
  }
  end();
  if (numbers.size() + 1 > longest) numbers.resize(longest - 1);
  numbers.push_back(last_);
  return numbers;
}

} // namespace innergs
