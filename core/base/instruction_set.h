// Which vector instructions this process computes with. Results are equal to the bit among machines
// with the same.
#ifndef CAGEFIT_CORE_BASE_INSTRUCTION_SET_H_
#define CAGEFIT_CORE_BASE_INSTRUCTION_SET_H_

namespace cagefit {

// Highway's name of it, such as "AVX2".
const char* InstructionSetName();

}  // namespace cagefit

#endif  // CAGEFIT_CORE_BASE_INSTRUCTION_SET_H_
