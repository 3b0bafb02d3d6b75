// The table of channels: every row is whole, and what is said of a channel once fits what its codec does.
#include "builder/channels/all_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace vt::channels {
namespace {

TEST(AllChannels, EveryOneIsFoundByNumberAndByName) {
  std::set<std::uint16_t> numbers;
  for (const ChannelKind* const kind : all_channels()) {
    numbers.insert(static_cast<std::uint16_t>(kind->type));
    EXPECT_EQ(&kind_of(kind->type), kind);
    EXPECT_EQ(find_channel(kind->name), kind);
    EXPECT_EQ(channel_name(kind->type), kind->name);
    EXPECT_NE(kind->make, nullptr) << kind->name;
    EXPECT_NE(kind->usual_format, nullptr) << kind->name;
  }
  // Every registered number has a row, and no row another number.
  EXPECT_EQ(*numbers.begin(), 1);
  EXPECT_EQ(ChannelType{*numbers.rbegin()}, ChannelType::kLastRegistered);
  EXPECT_EQ(numbers.size(), static_cast<std::size_t>(ChannelType::kLastRegistered));
  EXPECT_EQ(find_channel("colour"), nullptr);
}

TEST(AllChannels, UnknownNumbersHaveANameAndCannotBeMade) {
  for (const std::uint16_t number : {0, 9, 32768, 65535}) {
    const ChannelType type{number};
    EXPECT_EQ(channel_name(type), "channel " + std::to_string(number));
    EXPECT_TRUE(kind_of(type).options.empty());
    const auto made = make_codec({.channel = type}, {});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::kUnsupported);
  }
}

TEST(AllChannels, OptionsAreTheirOwn) {
  for (const ChannelKind* const kind : all_channels()) {
    std::set<std::string_view> names;
    for (const OptionInfo& option : kind->options) {
      EXPECT_TRUE(names.insert(option.name).second) << kind->name << ": " << option.name << " twice";
      EXPECT_EQ(kind->find_option(option.name), &option);
      EXPECT_TRUE(check_options(kind->type, {{std::string(option.name), ""}}));
    }
    EXPECT_EQ(kind->find_option("no-such-option"), nullptr);
  }
  const auto foreign = check_options(ChannelType::kMask, {{"frame", "enu"}});
  ASSERT_FALSE(foreign);
  EXPECT_EQ(foreign.error().message, "option frame does not belong to mask layers; theirs: inside, alpha-coverage");
}

// The usual format is one that the codec stores, of samples that every channel takes.
TEST(AllChannels, UsualFormatsAreTaken) {
  for (const ChannelKind* const kind : all_channels())
    for (const bool may_be_empty : {false, true}) {
      const SampleType type = kind->uses_declared_scale ? SampleType::kFloat32 : SampleType::kUint8;
      const SampleLayout layout{.type = type, .value_bands = kind->bands_wanted(3)};
      const auto made =
          make_codec({.channel = kind->type, .format = kind->usual_format(type, may_be_empty), .transfer = kind->transfer}, layout);
      EXPECT_TRUE(made) << kind->name << ": " << (made ? "" : made.error().message);
    }
}

}  // namespace
}  // namespace vt::channels
