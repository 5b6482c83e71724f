# Build-only flags: an interface target linked PRIVATE and never exported.
add_library(lcor_flags INTERFACE)
if(NOT MSVC)
  # -ffp-contract=off keeps results the same bytes on every compiler and CPU; -fno-math-errno and
  # -fno-trapping-math change no value and let loops vectorise.
  target_compile_options(lcor_flags INTERFACE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -Wvla -Wundef
    -ffp-contract=off -fno-math-errno -fno-trapping-math
    $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes -Wmissing-prototypes -Wwrite-strings>
    $<$<BOOL:${LCOR_WERROR}>:-Werror>)
endif()
