#include <gtest/gtest.h>

#include <functional>

#include "pipeline/formats/geometry_file.hpp"
#include "tests/support/temporary_files.hpp"

namespace meshmser {
namespace {

/// A file that cannot be read, and the whole message that says so ('@': the path of the file).
struct BadInput {
  std::string name;
  std::string content;
  std::string message;
  std::function<void(ReadOptions&)> choose = [](ReadOptions&) {};
};

const std::vector<BadInput>& bad_inputs() {
  static const std::vector<BadInput> inputs{
      {"empty.ply", "", "@: is empty; expected a scan or a mesh"},
      {"not.ply", "plx\n", "@:1: does not begin with 'ply' but 'plx'; is it a PLY file?"},
      {"cut_header.ply", "ply\nformat ascii 1.0\nelement vertex 2\n",
       "@: the header has no 'end_header'; the file is cut short or not a PLY file"},
      {"no_format.ply",
       "ply\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n",
       "@: the header has no 'format' line; expected 'format ascii 1.0' or a binary one"},
      {"encoding.ply", "ply\nformat binary_middle_endian 1.0\nend_header\n",
       "@:2: unknown PLY encoding 'binary_middle_endian'; expected ascii, binary_little_endian or binary_big_endian"},
      {"version.ply", "ply\nformat ascii 2.0\nend_header\n", "@:2: PLY version '2.0'; only 1.0 is known"},
      {"type.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty flot x\nend_header\n",
       "@:4: unknown PLY type 'flot'; expected one of char, uchar, short, ushort, int, uint, float, double"},
      {"list_type.ply", "ply\nformat ascii 1.0\nelement face 2\nproperty list float int vertex_indices\nend_header\n",
       "@:4: a list is counted in float; expected a whole-number type such as uchar"},
      {"nameless.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float\nend_header\n",
       "@:4: a property without a name; expected 'property TYPE NAME'"},
      {"orphan.ply", "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
       "@:3: a property before the first element; put 'element vertex COUNT' before it"},
      {"twice.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float x\nend_header\n",
       "@:5: property 'x' stands twice in element 'vertex'; rename one"},
      {"count.ply", "ply\nformat ascii 1.0\nelement vertex two\nend_header\n",
       "@:3: expected 'element NAME COUNT' with a whole number, found 'two'"},
      {"negative.ply", "ply\nformat ascii 1.0\nelement vertex -2\nend_header\n",
       "@:3: expected 'element NAME COUNT' with a whole number, found '-2'"},
      {"word.ply", "ply\nformat ascii 1.0\nelemnt vertex 2\nend_header\n",
       "@:3: unknown header line 'elemnt'; expected format, comment, obj_info, element, property or end_header"},
      {"no_vertex.ply", "ply\nformat ascii 1.0\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n",
       "@: has no element 'vertex'; expected points or a mesh"},
      {"no_points.ply",
       "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
       "@: has no vertices; expected points or a mesh"},
      {"no_z.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n",
       "@: element 'vertex' has no property 'z'; expected x, y and z"},
      {"two_vertices.ply",
       "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nelement vertex "
       "1\nproperty float w\nend_header\n0 0 0\n1 1 1\n2\n",
       "@: element 'vertex' stands twice in the header; expected it once"},
      {"short_row.ply",
       "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
       "3\n4 5\n",
       "@: the header announces 2 vertices, more than the 10 bytes after it can hold; the file is truncated or its "
       "header wrong"},
      {"long_row.ply",
       "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
       "3\n4 5 6 7\n",
       "@:9: too many values for element 'vertex': '4 5 6 7'; expected 3 properties"},
      {"letters.ply",
       "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
       "3\n4 five 6\n",
       "@:9: 'five' is not a number; expected the properties of element 'vertex', separated by blanks"},
      {"few_rows.ply",
       "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1.5 "
       "2.5 3.5\n\n\n",
       "@:11: the file ends before vertex 1 of 2; it is truncated, copy it again"},
      {"absurd_ascii.ply",
       "ply\nformat ascii 1.0\nelement vertex 2000000000\nproperty float x\nproperty float y\nproperty float "
       "z\nend_header\n1 2 3\n",
       "@: the header announces 2000000000 vertices, more than the 6 bytes after it can hold; the file is truncated or "
       "its header wrong"},
      {"beyond.ply",
       "ply\nformat ascii 1.0\nelement vertex 9000000000\nproperty float x\nproperty float y\nproperty float "
       "z\nend_header\n1 2 3\n",
       "@: the header announces 9000000000 'vertex' rows; at most 2147483647 are possible"},
      {"truncated.ply",
       std::string(
           "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
           "z\nend_header\n\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?"
           "\000\000\000\000\000\000\000\000",
           139),
       "@: ends at byte 139 inside vertex 2 of 3; the file is truncated, copy it again"},
      {"absurd.ply",
       std::string("ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\nproperty float x\nproperty float "
                   "y\nproperty float "
                   "z\nend_header\n\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?"
                   "\000\000\000\000\000\000\000\000",
                   148),
       "@: ends at byte 148 inside vertex 2 of 2000000000; the file is truncated, copy it again"},
      {"short_list.ply",
       std::string("ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float "
                   "y\nproperty float z\nelement face 1\nproperty list uchar int "
                   "vertex_indices\nend_header\n\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?"
                   "\000\000\000\000\000\000\000\000\003\000\000\000\000",
                   198),
       "@: ends at byte 198 inside face 0 of 1; the file is truncated, copy it again"},
      {"negative_list.ply",
       std::string("ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float "
                   "y\nproperty float z\nelement face 1\nproperty list char int "
                   "vertex_indices\nend_header\n\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?"
                   "\000\000\000\000\000\000\000\000\377\000\000\000\000",
                   197),
       "@: face 0 of 1: a list of -1 items at byte 192; the file is damaged"},
      {"no_list.ply",
       std::string("ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float "
                   "y\nproperty float z\nelement face 1\nproperty int "
                   "flags\nend_header\n\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?"
                   "\000\000\000\000\000\000\000\000\377\000\000\000\000",
                   178),
       "@: element 'face' has no list 'vertex_indices'; expected 'property list uchar int vertex_indices'"},
      {"beyond_face.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
       "@: face 0 names vertex 3; the file has vertices 0 to 2"},
      {"negative_face.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n",
       "@: face 0 names vertex -1; the file has vertices 0 to 2"},
      {"half_face.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n",
       "@: face 0 of 1: 1.5 is not the number of a vertex; expected a whole number from 0"},
      {"two_corners.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n",
       "@: face 0 has 2 corners; expected at least 3"},
      {"long_list.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n300 0 1 2\n",
       "@:13: a list of 300 items does not fit its line; expected the count, then so many numbers"},
      {"empty.xyz", "\n\n# nothing\n", "@: holds no points; expected lines of numbers 'x y z'"},
      {"utf16.xyz", std::string("\377\3761\000 \000", 6), "@: is UTF-16 text; save it as UTF-8 or plain ASCII"},
      {"binary.xyz", std::string("1 2 3\n\000\000\000\000", 10),
       "@: holds binary data (a zero byte at 6); expected text, or name its format with 'format'"},
      {"two.xyz", "1 2\n3 4\n", "@:1: '1 2' has 2 columns; expected at least x, y and z"},
      {"one_short.xyz", "1 2 3\n4 5\n",
       "@:2: '4 5' has 2 columns; the lines before have 3; mend it, or set 'skip_bad_lines: true'"},
      {"one_long.xyz", "1 2 3\n4 5 6 7\n",
       "@:2: '4 5 6 7' has 4 columns; the lines before have 3; mend it, or set 'skip_bad_lines: true'"},
      {"word.xyz", "1 2 3\n4 5 x\n", "@:2: 'x' is not a number; mend the line, or set 'skip_bad_lines: true'"},
      {"comma.xyz", "1,5 2,5 3,5\n",
       "@:1: '5 2' is not a number; if numbers have a decimal comma, set 'decimal_comma: true'"},
      {"comma.csv", "1,5;2,5;3,5\n",
       "@:1: '1,5' is not a number; if numbers have a decimal comma, set 'decimal_comma: true'"},
      {"first_word.xyz", "1 2 three\n1 2 3\n",
       "@:1: 'three' is not a number; expected 'x y z' and further columns of numbers, or 'skip_bad_lines: true'"},
      {"two_headers.csv", "a,b,c\nd,e,f\n1,2,3\n",
       "@:2: 'd' is not a number; expected 'x y z' and further columns of numbers, or 'skip_bad_lines: true'"},
      {"no_xyz.csv", "east,north,up,grey\n1,2,3,4\n",
       "@:2: the header names the columns east north up grey, without x, y and z; say which they are with 'columns'"},
      {"gap.csv", "x,y,z\n1,2,3\n1,,3\n", "@:3: '' is not a number; mend the line, or set 'skip_bad_lines: true'"},
      {"columns.xyz", "1 2 3 4\n",
       "@:1: 4 columns, but 'columns' names 3 (x y z); name every column, '_' for those to leave out",
       [](ReadOptions& options) {
         options.text.columns = {"x", "y", "z"};
       }},
      {"columns_xy.xyz", "1 2 3\n", "@: 'columns' (x y w) does not name 'z'; expected x, y and z among them",
       [](ReadOptions& options) {
         options.text.columns = {"x", "y", "w"};
       }},
      {"columns_twice.xyz", "1 2 3 4 5\n",
       "@: column 'a' is named twice; rename one with 'columns', or leave it out with '_'",
       [](ReadOptions& options) {
         options.text.columns = {"x", "y", "z", "a", "a"};
       }},
      {"count.pts", "3\n1 2 3\n4 5 6\n",
       "@:4: 3 points were announced in line 1, but 2 follow; the file is truncated, or remove the count"},
      {"count_over.pts", "1\n1 2 3\n4 5 6\n",
       "@:4: 1 points were announced in line 1, but 2 follow; the file is truncated, or remove the count"},
      {"negative.pts", "-1\n1 2 3\n", "@:1: -1 points are announced; expected a whole number from 0"},
      {"all_bad.xyz", "1 2 x\n", "@: holds no points: 1 bad lines were skipped; expected lines of numbers 'x y z'",
       [](ReadOptions& options) { options.text.skip_bad_lines = true; }},
      {"decimal.csv", "1.5,2.5,3.5\n",
       "@:1: '1.5.2.5.3.5' is not a number; expected 'x y z' and further columns of numbers, or 'skip_bad_lines: true'",
       [](ReadOptions& options) { options.text.decimal_comma = true; }},
      {"head.off", "OOF\n1 0 0\n0 0 0\n",
       "@:1: begins with 'OOF'; expected OFF, COFF, NOFF or CNOFF (the variants with texture or four coordinates are "
       "not read)"},
      {"four.off", "4OFF\n1 0 0\n0 0 0 0\n",
       "@:1: begins with '4OFF'; expected OFF, COFF, NOFF or CNOFF (the variants with texture or four coordinates are "
       "not read)"},
      {"binary.off", "OFF BINARY\n1 0 0\n", "@:1: is a binary OFF file; save it as text, or as PLY"},
      {"counts.off", "OFF\n3 x 0\n", "@:2: 'x' is not the number of faces; expected a whole number"},
      {"none.off", "OFF\n0 0 0\n", "@:2: 0 vertices and 0 faces; expected at least one vertex"},
      {"absurd.off", "OFF\n2000000000 1 0\n0 0 0\n",
       "@:2: 2000000000 vertices and 1 faces do not fit into 25 bytes; the file is truncated or the counts are wrong"},
      {"coordinate.off", "OFF\n1 0 0\n0 zero 0\n", "@:3: 'zero' is not a coordinate; expected a number"},
      {"truncated.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n",
       "@:5: the file ends before all its vertices; it is truncated, or the counts in its head are wrong"},
      {"long.off", "OFF\n1 0 0\n0 0 0 0\n", "@:3: too many values for a vertex: '0 0 0 0'; expected 3"},
      {"face.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n",
       "@:6: the face names vertex 7; the file has vertices 0 to 2"},
      {"corners.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n",
       "@:6: a face of 2 corners; expected 3 or more, then so many vertices"},
      {"vertex.obj", "v 1 2\n", "@:1: too few values for a vertex: 'v 1 2'; expected 'v x y z'"},
      {"number.obj", "v 1 2 x\n", "@:1: 'x' is not a number; expected 'v x y z'"},
      {"face.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
       "@:4: the face names vertex 4; there are vertices 1 to 3 before it"},
      {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
       "@:4: the face names vertex 0; there are vertices 1 to 3 before it"},
      {"corners.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "@:4: a face of 2 corners: 'f 1 2'; expected at least 3"},
      {"corner.obj", "v 0 0 0\nf a b c\n", "@:2: 'a' is not a corner; expected 'f v v v' or 'f v/vt/vn ...'"},
      {"colours.obj", "v 0 0 0 1 1 1\nv 0 0 1\n",
       "@:2: some vertices have colours and some have none; expected all or none"},
      {"nothing.obj", "# only this\n", "@: holds no vertices; expected lines 'v x y z'"},
      {"short.stl", std::string("\000\000\000", 3),
       "@: has 3 bytes and does not begin with 'solid'; a binary STL file has at least 84"},
      {"none.stl",
       std::string("                                                                                \000\000\000\000",
                   84),
       "@: holds no facets; expected a mesh"},
      {"truncated.stl",
       std::string("                                                                                "
                   "\003\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
                   "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
                   "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000",
                   144),
       "@: ends at byte 144 inside facet 1 of 3; the file is truncated, copy it again"},
      {"absurd.stl",
       std::string(
           "                                                                                "
           "\000("
           "k\356\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000"
           "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000",
           134),
       "@: announces 4000000000 facets; at most 715827882 are possible"},
      {"ends.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
       "@:5: the file ends without 'endsolid'; it is truncated, copy it again"},
      {"two.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n",
       "@:7: a facet of 2 vertices; expected three"},
      {"grid.ply",
       "ply\nformat ascii 1.0\nobj_info num_cols 1\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
       "float "
       "z\nelement range_grid 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n0\n1 7\n",
       "@: range_grid cell 1 names vertex 7; the file has vertices 0 to 0"},
      {"number.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 o\n",
       "@:4: 'o' is not a number; expected 'vertex x y z'"},
      {"word.stl", "solid a\nfact normal 0 0 1\nendsolid\n",
       "@:2: unknown word 'fact'; expected solid, facet, outer, vertex, endloop, endfacet or endsolid"},
      {"stray.stl", "solid a\nvertex 0 0 0\nendsolid\n",
       "@:2: a vertex outside a facet; expected 'facet normal' before it"},
      {"columns.ptx", "x\n1\n",
       "@:1: 'x' is not the number of columns; expected a whole number (PTX begins with the columns and rows of its "
       "grid)"},
      {"matrix.ptx", "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 2\n",
       "@:10: the matrix is not a motion: expected 0 0 0 1 in its last column and the translation in its last row"},
      {"axis.ptx", "1\n1\n0 0 0\n1 0\n", "@:4: '1 0' is not an axis of the scanner; expected three numbers"},
      {"cut_head.ptx", "1\n1\n0 0 0\n", "@:4: the file ends before the scanner's axes; it is truncated, copy it again"},
      {"truncated.ptx", "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1.25 2.25 3.25 0.5\n",
       "@:12: the file ends before the last cell of the grid; it is truncated, copy it again"},
      {"absurd.ptx",
       "2000000000\n2000000000\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n",
       "@:2: a grid of 2000000000 x 2000000000 cells does not fit into the 66 bytes that follow; the file is truncated "
       "or its head wrong"},
      {"widths.ptx", "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n1 2 3\n",
       "@:12: '1 2 3' has 3 columns; the cells before have 4"},
      {"unmeasured.ptx", "2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0 0 0 0.5\n0 0 0 0.5\n",
       "@: holds no measured points; expected scans in PTX form"},
      {"no_data.pcd", "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n",
       "@: the header has no 'DATA' line; the file is cut short or not a PCD file"},
      {"encoding.pcd",
       "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA zip\n",
       "@:9: 'DATA zip' is not a known encoding; expected 'DATA ascii', 'DATA binary' or 'DATA binary_compressed'"},
      {"no_fields.pcd", "VERSION .7\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1\n",
       "@: the header has no 'FIELDS' line; expected 'FIELDS x y z ...'"},
      {"sizes.pcd",
       "VERSION .7\nFIELDS x y z\nSIZE 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3\n",
       "@: the header has 3 fields, 2 sizes, 3 types and 3 counts; expected one of each for every field"},
      {"kind.pcd",
       "VERSION .7\nFIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 "
       "3\n",
       "@: field 'z' has type F and size 3; expected I or U of 1, 2, 4 or 8 bytes, or F of 4 or 8"},
      {"counts.pcd",
       "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 "
       "3\n",
       "@: the header announces 2 points, but WIDTH 3 x HEIGHT 1; make them agree"},
      {"no_z.pcd",
       "VERSION .7\nFIELDS x y w\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 "
       "3\n4 5 6\n",
       "@: has no field 'z'; expected x, y and z"},
      {"few.pcd",
       "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 "
       "3\n4 5\n",
       "@:11: too few values for a point: '4 5'; expected 3"},
      {"ends.pcd",
       "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1.25 "
       "2.25 3.25\n",
       "@:11: the file ends before point 1 of 2; it is truncated, copy it again"},
      {"truncated.pcd",
       std::string("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
                   "binary\n\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?\000\000\000\000",
                   116),
       "@: ends at byte 116 inside point 1 of 2; the file is truncated, copy it again"},
      {"absurd.pcd",
       std::string(
           "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2000000000\nHEIGHT 1\nPOINTS "
           "2000000000\nDATA "
           "binary\n\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200?\000\000\000\000\000\000\000\000",
           138),
       "@: ends at byte 138 inside point 2 of 2000000000; the file is truncated, copy it again"},
      {"compressed.pcd",
       std::string("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
                   "binary_"
                   "compressed\n\031\000\000\000c\000\000\000\027\000\000\000\000\000\000\000\000\000\000\000\000\000"
                   "\000\200?\000\000\000\000\000\000\000\000",
                   140),
       "@: its compressed data hold 99 bytes, but 2 points of 12 bytes are announced; the file is damaged"},
      {"compressed_cut.pcd",
       std::string("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
                   "binary_compressed\n\031\000\000\000\030\000\000\000\027\000\000\000\000\000\000\000\000\000\000",
                   126),
       "@: ends at byte 126 inside its compressed data; the file is truncated, copy it again"},
      {"damaged.pcd",
       std::string("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA "
                   "binary_"
                   "compressed\n\031\000\000\000\030\000\000\000\377\377\377\377\377\377\377\377\377\377\377\377\377"
                   "\377\377\377\377\377\377\377\377\377\377\377\377",
                   140),
       "@: its data are damaged: they do not decompress; copy the file again"},
      {"word.pcd", "VERSION .7\nFELDS x y z\nDATA ascii\n",
       "@:2: 'FELDS x y z' is not a PCD header line; expected VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, "
       "VIEWPOINT, POINTS or DATA"},
      {"scan.abc", "1 2 3\n", "@: unknown format; name it with 'format', one of ply, xyz, pcd, off, obj, stl, ptx"},
      {"options.ply",
       "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
       "3\n4 5 6\n",
       "@: 'columns', 'decimal_comma' and 'skip_bad_lines' are for text of one point a line, this is read as 'ply'; "
       "leave them out",
       [](ReadOptions& options) { options.text.decimal_comma = true; }},
      {"format.xyz", "1 2 3\n",
       "@: unknown format 'las'; name it with 'format', one of ply, xyz, pcd, off, obj, stl, ptx",
       [](ReadOptions& options) { options.format = "las"; }},
  };
  return inputs;
}

TEST(BadInput, EachIsOneInputErrorThatSaysWhereAndWhat) {
  ASSERT_GE(bad_inputs().size(), 60u);
  for (const BadInput& input : bad_inputs()) {
    TemporaryFolder folder;
    const std::filesystem::path path = folder.write(input.name, input.content);
    ReadOptions options;
    input.choose(options);
    try {
      read_geometry_file(path, options);
      ADD_FAILURE() << input.name << " was read";
    } catch (const InputError& error) {
      std::string message = error.what();
      ASSERT_TRUE(message.starts_with(path.string())) << message;
      EXPECT_EQ("@" + message.substr(path.string().size()), input.message) << input.name;
    }
  }
}

TEST(BadInput, MissingFilesAndFolders) {
  TemporaryFolder folder;
  for (const auto& [path, message] :
       {std::pair(folder.path() / "none.ply", "no such file"), std::pair(folder.path(), "is a folder")}) {
    try {
      read_geometry_file(path);
      ADD_FAILURE() << path << " was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace meshmser
