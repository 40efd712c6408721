#pragma once
#include <cstdint>
#include <vector>

namespace meshmser {

/// What became of a node of a component tree in selection and filters.
struct NodeFate {
  enum class Kind : std::uint8_t {
    kRegion,            ///< selected, and passed every filter
    kRoot,              ///< has no level border
    kLessStable,        ///< `rival`, linked to it or to its plateau, has a lower q
    kSmallerOfPlateau,  ///< `rival` is the largest node of a plateau of equal q
    kNoMaximum,         ///< holds no significant maximum
    kSeveralMaxima,     ///< holds several
    kSingleMaximum,     ///< no significant maximum other than its own lies anywhere in its component
    kSmallerOfMaximum,  ///< `rival` is the largest node with the same significant maximum
    kNotOnBranch,       ///< `rival` is the node of least q that was taken on the way to the same maximum
    kShortLine,         ///< its level line is shorter than asked for
    kOtherLevel,        ///< not a component of the level asked for
    kFalseAlarm,        ///< a level line as long and steep may well be chance
    kLessMeaningful,    ///< `rival`, of the same monotone section, has fewer false alarms
    kFiltered,          ///< `filter` took it out, for `rival` where there is one
  };
  Kind kind = Kind::kRegion;
  std::int32_t filter = -1;  ///< index into Segmentation::filters
  std::int32_t rival = -1;   ///< a node of the same tree; -1: none

  bool operator==(const NodeFate&) const = default;

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("kind", self.kind);
    field("filter", self.filter);
    field("rival", self.rival);
  }
};

/// Of all nodes of one tree, by node.
struct TreeFates {
  std::vector<NodeFate> nodes;

  template <class Self, class Visitor>
  static void visit(Self& self, Visitor&& field) {
    field("nodes", self.nodes);
  }
};

}  // namespace meshmser
