#include "stages/report/page_template.hpp"

// The assembler puts the file into the program's read-only data: no compiler has to read a string of a megabyte.
asm(R"(
  .pushsection .rodata
  .global meshmser_page_template_begin
  .global meshmser_page_template_end
meshmser_page_template_begin:
  .incbin ")" MESHMSER_PAGE_TEMPLATE R"("
meshmser_page_template_end:
  .byte 0
  .popsection
)");

extern "C" {
extern const char meshmser_page_template_begin[];
extern const char meshmser_page_template_end[];
}

namespace meshmser {

std::string_view page_template() {
  return {meshmser_page_template_begin,
          static_cast<std::size_t>(meshmser_page_template_end - meshmser_page_template_begin)};
}

}  // namespace meshmser
