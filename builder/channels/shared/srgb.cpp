#include "builder/channels/shared/srgb.h"

namespace vt::channels {

const CodeTable& code_table(Transfer transfer) {
  static const CodeTable linear(Transfer::kLinear);
  static const CodeTable srgb(Transfer::kSrgb);
  return transfer == Transfer::kSrgb ? srgb : linear;
}

}  // namespace vt::channels
