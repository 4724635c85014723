#include "core/base/instruction_set.h"

// Highway compiles this file once per instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/base/instruction_set.cc"  // NOLINT
#include <hwy/foreach_target.h>                            // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace cagefit {
namespace HWY_NAMESPACE {

const char* Name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace cagefit
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cagefit {
HWY_EXPORT(Name);

const char* InstructionSetName() { return HWY_DYNAMIC_DISPATCH(Name)(); }

}  // namespace cagefit
#endif  // HWY_ONCE
