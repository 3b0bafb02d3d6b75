// The table of channels: every row is whole, and what is said of a channel once fits what its codec does.
#include "builder/channels/all_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
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

// The list of formats is the whole truth: of no other format is a codec made, and none of the list is refused
// for itself. Layers of some formats need options beside; what is missing is what is said then.
TEST(AllChannels, FormatsAreThoseOfTheList) {
  for (const ChannelKind* const kind : all_channels()) {
    const std::span<const TexelFormat> formats = kind->formats({});
    ASSERT_FALSE(formats.empty()) << kind->name;
    EXPECT_THAT(formats, testing::Contains(kind->usual_format(SampleType::kUint8, false)));
    for (const FormatInfo& info : kTexelFormats) {
      const TexelFormat format = info.format;
      const bool is_listed = std::ranges::find(formats, format) != formats.end();
      const auto made = make_codec({.channel = kind->type, .format = format, .transfer = kind->transfer},
                                   {.type = SampleType::kUint8, .value_bands = kind->bands_wanted(3)});
      if (made) {
        EXPECT_TRUE(is_listed) << kind->name << " " << format_info(format).name;
      } else {
        const std::string start = std::string(kind->name) + " layers cannot be stored as " + std::string(format_info(format).name);
        EXPECT_EQ(made.error().message.starts_with(start), !is_listed) << made.error().message;
      }
    }
  }
  const auto scene = make_codec({.channel = ChannelType::kNormal, .format = TexelFormat::kBc5, .options = {{"frame", "scene"}}},
                                {.type = SampleType::kUint8, .value_bands = 3});
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().message,
            "normal layers cannot be stored as bc5 in the scene's frame: it leaves z to be computed as positive, and there z may be "
            "negative; use rgb8 or rgba16");
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
