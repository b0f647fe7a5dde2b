#include "Text/WordPiece.h"
#include "Onnx/TestNetworks.h"
#include "ThrownError.h"

#include <fstream>

namespace innergs {
namespace {

using Numbers = std::vector<std::int64_t>;

class WordPieceTest : public ::testing::Test {
protected:
  /// [PAD] 0, [UNK] 1, [CLS] 2, [SEP] 3, then the pieces from 4 on.
  WordPiece wordPieceOf(const std::vector<std::string>& pieces, const std::string& lineEnd = "\n") {
    std::ofstream out(folder_ / "vocab.txt", std::ios::binary);
    for (const char* special : {"[PAD]", "[UNK]", "[CLS]", "[SEP]"})
      out << special << lineEnd;
    for (const std::string& piece : pieces)
      out << piece << lineEnd;
    out.close();
    return WordPiece(folder_ / "vocab.txt");
  }
  testing::TestFolder folder_;
};

TEST_F(WordPieceTest, LongestPieceFromTheLeft) {
  const WordPiece pieces = wordPieceOf({"un", "##aff", "##able", "##a", "liver", "##s"});
  EXPECT_EQ(pieces.numbersOf("unaffable"), (Numbers{2, 4, 5, 6, 3}));
  EXPECT_EQ(pieces.numbersOf("livers"), (Numbers{2, 8, 9, 3}));
  EXPECT_EQ(pieces.numbersOf("liver unx"), (Numbers{2, 8, 1, 3})); // known as a whole or not at all
  EXPECT_EQ(pieces.numbersOf(std::string(101, 'a')), (Numbers{2, 1, 3}));
  EXPECT_EQ(pieces.numbersOf(""), (Numbers{2, 3}));
}

TEST_F(WordPieceTest, CaseAccentsAndPunctuationAreBerts) {
  const WordPiece pieces =
      wordPieceOf({"foie", "l", "'", ",", "\xc3\x9f", "\xe8\x82\x9d", "\xce\xb1", "\xc5\x82", "i"}, "\r\n");
  EXPECT_EQ(pieces.numbersOf("L'Fo\xc3\xaf"
                             "e, foi\xcc\x88"
                             "e"),
            (Numbers{2, 5, 6, 4, 7, 4, 3}));
  EXPECT_EQ(pieces.numbersOf("\xc3\x9f \xce\x91 \xc5\x81 \xc4\xaf"), (Numbers{2, 8, 10, 11, 12, 3}));
  EXPECT_EQ(pieces.numbersOf("\xe8\x82\x9d\xe8\x82\x9d"), (Numbers{2, 9, 9, 3})); // a word each
  EXPECT_EQ(pieces.numbersOf("\xff\tfoie\x01"), (Numbers{2, 4, 3}));
  // I with a dot above, capital sharp s, i with a hook above and with a caron
  EXPECT_EQ(pieces.numbersOf("\xc4\xb0 \xe1\xba\x9e \xe1\xbb\x89 \xc7\x90"), (Numbers{2, 12, 8, 12, 12, 3}));
}

TEST_F(WordPieceTest, KeepsTheEndOfALongText) {
  const WordPiece pieces = wordPieceOf({"a"});
  EXPECT_EQ(pieces.numbersOf("a a a a a a", 5), (Numbers{2, 4, 4, 4, 3}));
}

TEST_F(WordPieceTest, ForeignVocabularyIsOneSentence) {
  EXPECT_THROW(WordPiece(folder_ / "nowhere.txt"), Error);
  std::ofstream(folder_ / "foreign.txt") << "liver\nspleen\n";
  EXPECT_EQ(test::codeOf([&] { WordPiece(folder_ / "foreign.txt"); }), ErrorCode::FileFormat);
}

} // namespace
} // namespace innergs
