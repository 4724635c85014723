// Which distance field samples are held to.
#ifndef CAGEFIT_CORE_ENERGY_FIELD_H_
#define CAGEFIT_CORE_ENERGY_FIELD_H_

namespace cagefit {

enum class Field {
  kImls,  // cloud/imls.h
  kRimls  // cloud/rimls.h: keeps edges
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_FIELD_H_
