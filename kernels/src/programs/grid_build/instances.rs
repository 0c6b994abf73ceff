//! The instances of the kernels in the program: what each is launched over, which streams it gets, and which kind of grid
//! it is only for.

use super::PROGRAM;
use super::elements::*;
use super::irregular::kernels::*;
use super::kernels::*;
use super::reasons;
use super::streams::*;
use crate::program::{Instance, Kernel, KernelInfo};
use crate::tables::elements::Elements;
use crate::tables::stream::Stream;

type Binds = &'static [(&'static str, &'static str)];

macro_rules! instances {
    ($($id:ident $name:literal: $row:ident over $over:ident $(by $parameter:literal)? $(binds $binds:ident)? $(renews $renews:ident)? $(adopts $adopts:ident)? $(only $kind:ident)?;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Index { $($id),* }

        /// All instances, in the order of the build.
        pub static KERNELS: [Instance; [$(Index::$id as usize),*].len()] = [$(Instance {
            name: $name,
            kernel: instances!(@row $row $($kind)?),
            over: &$over,
            parameter: 0 $(+ $parameter)?,
            binds: instances!(@list $($binds)?),
            renamed: None,
            sets: &[],
            follows: &[],
            renews: instances!(@list $($renews)?),
            adopts: instances!(@list $($adopts)?),
            copies: &[],
        }),*];

        $(pub(super) const $id: Kernel = Kernel::at(&PROGRAM, Index::$id as usize);)*
    };
    (@row $row:ident) => { $row };
    (@row $row:ident $kind:ident) => { KernelInfo { why_absent: reasons::$kind, ..$row } };
    (@list) => { &[] };
    (@list $list:ident) => { $list };
}

const SPAN_SUMS: Binds = &[("values", "first_span"), ("sums", "spans_of_block")];
const ALL_SPAN_SUMS: Binds = &[("values", "spans_of_block"), ("sums", "spans_in_all")];
const OF_SPAN: Binds = &[("triangle", "span_triangle"), ("cells_at", "span_cell")];
const EMITTED: Binds = &[
    ("triangle", "span_triangle"),
    ("cells_at", "span_cell"),
    ("cell_out", "cell_even"),
    ("triangle_out", "triangle_even"),
];
const REFERENCE_SUMS: Binds = &[("values", "first_reference"), ("sums", "references_of_block")];
const ALL_REFERENCE_SUMS: Binds = &[("values", "references_of_block"), ("sums", "references_in_all")];
const TALLY_SUMS: Binds = &[("values", "tally"), ("sums", "tally_of_block")];
const ALL_TALLY_SUMS: Binds = &[("values", "tally_of_block"), ("sums", "tally_in_all")];
const START_SUMS: Binds = &[("values", "start"), ("sums", "starts_of_block")];
const ALL_START_SUMS: Binds = &[("values", "starts_of_block"), ("sums", "starts_in_all")];
const FROM_EVEN: Binds =
    &[("key_in", "cell_even"), ("value_in", "triangle_even"), ("key_out", "cell_odd"), ("value_out", "triangle_odd")];
const FROM_ODD: Binds =
    &[("key_in", "cell_odd"), ("value_in", "triangle_odd"), ("key_out", "cell_even"), ("value_out", "triangle_even")];
const CELLS_EVEN: Binds = &[("cell_in", "cell_even")];
const CELLS_ODD: Binds = &[("cell_in", "cell_odd")];
const TAKEN_EVEN: Binds =
    &[("first_in", "cell_even"), ("second_in", "triangle_even"), ("first_out", "owner"), ("second_out", "item")];
const TAKEN_ODD: Binds =
    &[("first_in", "cell_odd"), ("second_in", "triangle_odd"), ("first_out", "owner"), ("second_out", "item")];
const IN_HALVES: Binds = &[("tally", "in_halves")];
const HALF_SUMS: Binds = &[("values", "in_halves"), ("sums", "in_halves_of_block")];
const ALL_HALF_SUMS: Binds = &[("values", "in_halves_of_block"), ("sums", "in_halves_in_all")];
const PLACE_SUMS: Binds = &[("values", "places"), ("sums", "places_of_block")];
const ALL_PLACE_SUMS: Binds = &[("values", "places_of_block"), ("sums", "totals")];
const KEPT_SUMS: Binds = &[("values", "kept"), ("sums", "kept_of_block")];
const ALL_KEPT_SUMS: Binds = &[("values", "kept_of_block"), ("sums", "totals")];
const OPENED_SUMS: Binds = &[("values", "opened"), ("sums", "opened_of_block")];
const ALL_OPENED_SUMS: Binds = &[("values", "opened_of_block"), ("sums", "nodes_in_all")];
const ENTRY_SUMS: Binds = &[("values", "first_entry"), ("sums", "entries_of_block")];
const ALL_ENTRY_SUMS: Binds = &[("values", "entries_of_block"), ("sums", "entries_in_all")];
const OF_TOP: Binds = &[("map_entries", "map_top"), ("faults", "top_faults")];
const OF_BLOCKS: Binds = &[("map_entries", "map_below"), ("faults", "entry_faults")];
const OF_STARTS: Binds = &[("faults", "start_faults")];
const ITEMS_EVEN: Binds = &[("item", "triangle_even"), ("faults", "reference_faults")];
const ITEMS_ODD: Binds = &[("item", "triangle_odd"), ("faults", "reference_faults")];
const OF_CELLS: Binds = &[("faults", "cell_faults")];
const OF_ITEMS: Binds = &[("faults", "item_faults")];
const AS_EXPANDED: Binds = &[("box", "expanded")];
const AS_IT_IS: Binds = &[("box", "space")];

type Renews = &'static [&'static Elements];

const FIRST_LEAVES: Renews = &[&LEAVES, &LISTED];
const REPLACED: Renews = &[&NEXT_LEAVES, &NEXT_LISTED, &LEFT];
const MERGED: Renews = &[&NEXT_LEAVES, &NEXT_LISTED];
const ROUNDS: Renews = &[&ROUNDS_AHEAD];

type Adopts = &'static [(Stream, Stream)];

const DIVIDED: Adopts =
    &[(SPACE, NEXT_SPACE), (LIST, NEXT_LIST), (DIVISION, NEXT_DIVISION), (OWNER, NEXT_OWNER), (ITEM, NEXT_ITEM)];
const GATHERED: Adopts = &[(SPACE, NEXT_SPACE), (LIST, NEXT_LIST), (ITEM, NEXT_ITEM)];

instances! {
    FIND_BOUNDS "bound": BOUND over TRIANGLES;
    SCAN_SPANS "scan_spans": SCAN over TRIANGLES binds SPAN_SUMS;
    SCAN_SPAN_BLOCKS "scan_span_blocks": SCAN over TRIANGLE_BLOCKS binds ALL_SPAN_SUMS;
    ADD_SPANS "add_spans": ADD over TRIANGLES binds SPAN_SUMS;
    TEST_SPANS "span": SPAN over SPANS binds OF_SPAN;
    SCAN_REFERENCES "scan_references": SCAN over SPANS binds REFERENCE_SUMS;
    SCAN_REFERENCE_BLOCKS "scan_reference_blocks": SCAN over SPAN_BLOCKS binds ALL_REFERENCE_SUMS;
    ADD_REFERENCES "add_references": ADD over SPANS binds REFERENCE_SUMS;
    EMIT_REFERENCES "emit": EMIT over SPANS binds EMITTED;
    HISTOGRAM_EVEN "histogram_even": HISTOGRAM over REFERENCES binds FROM_EVEN;
    SCAN_TALLIES "scan_tallies": SCAN over TALLIES binds TALLY_SUMS;
    SCAN_TALLY_BLOCKS "scan_tally_blocks": SCAN over TALLY_BLOCKS binds ALL_TALLY_SUMS;
    ADD_TALLIES "add_tallies": ADD over TALLIES binds TALLY_SUMS;
    SCATTER_EVEN "scatter_even": SCATTER over REFERENCES binds FROM_EVEN;
    HISTOGRAM_ODD "histogram_odd": HISTOGRAM over REFERENCES binds FROM_ODD;
    SCATTER_ODD "scatter_odd": SCATTER over REFERENCES binds FROM_ODD;
    MARK_EVEN "mark_even": MARK over REFERENCES binds CELLS_EVEN;
    MARK_ODD "mark_odd": MARK over REFERENCES binds CELLS_ODD;
    MEASURE_LISTS "measure": MEASURE over CELLS;
    SCAN_STARTS "scan_starts": SCAN over CELLS binds START_SUMS;
    SCAN_START_BLOCKS "scan_start_blocks": SCAN over CELL_BLOCKS binds ALL_START_SUMS;
    ADD_STARTS "add_starts": ADD over CELLS binds START_SUMS;
    COUNT_TOP_LEVEL "count_top": COUNT_TOP over WHOLE only divided;
    MAKE_FIRST_LEAVES "make_leaves": MAKE_LEAVES over CELLS renews FIRST_LEAVES only divided;
    FIND_DEPTH "start_halving": START_HALVING over WHOLE only divided;
    TAKE_EVEN "take_even": ADOPT over REFERENCES binds TAKEN_EVEN only divided;
    TAKE_ODD "take_odd": ADOPT over REFERENCES binds TAKEN_ODD only divided;
    FIND_HALVES "halve": HALVE over LISTED binds IN_HALVES adopts DIVIDED only divided;
    SCAN_HALVES "scan_halves": SCAN over GROUPS binds HALF_SUMS only divided;
    SCAN_HALF_BLOCKS "scan_half_blocks": SCAN over GROUP_BLOCKS binds ALL_HALF_SUMS only divided;
    ADD_HALVES "add_halves": ADD over GROUPS binds HALF_SUMS only divided;
    DECIDE_DIVISION "decide": DECIDE over LEAVES binds IN_HALVES only divided;
    SCAN_PLACES "scan_places": SCAN over LEAVES binds PLACE_SUMS only divided;
    SCAN_PLACE_BLOCKS "scan_place_blocks": SCAN over LEAF_BLOCKS binds ALL_PLACE_SUMS only divided;
    DIVIDE_LEAVES "divide": DIVIDE over LEAVES binds IN_HALVES renews REPLACED only divided;
    HAND_DOWN_LISTS "hand_down": HAND_DOWN over LISTED binds IN_HALVES only divided;
    TURN_TO_NEXT_HALVING "next_halving": NEXT_HALVING over WHOLE only divided;
    COUNT_NODES "open_nodes": OPEN_NODES over LEAVES adopts DIVIDED only divided;
    SCAN_OPENED "scan_opened": SCAN over LEAVES binds OPENED_SUMS only divided;
    SCAN_OPENED_BLOCKS "scan_opened_blocks": SCAN over LEAF_BLOCKS binds ALL_OPENED_SUMS only divided;
    LINK_TREES "link_nodes": LINK_NODES over LEAVES only divided;
    FIND_BLOCKS "size_blocks": SIZE_BLOCKS over NODES only divided;
    SCAN_ENTRIES "scan_entries": SCAN over NODES binds ENTRY_SUMS only divided;
    SCAN_ENTRY_BLOCKS "scan_entry_blocks": SCAN over NODE_BLOCKS binds ALL_ENTRY_SUMS only divided;
    ADD_ENTRIES "add_entries": ADD over NODES binds ENTRY_SUMS only divided;
    MAP_TOP_CELLS "map_top_level": MAP_TOP_LEVEL over CELLS only divided;
    MAP_ALL_BLOCKS "map_blocks": MAP_BLOCKS over ENTRIES only divided;
    BEGIN_MERGING "start_merging": START_MERGING over WHOLE only irregular;
    FIND_WISHES "wish": WISH over LEAVES adopts GATHERED only irregular;
    UNITE_LEAVES "unite": UNITE over LEAVES only irregular;
    SCAN_KEPT "scan_kept": SCAN over LEAVES binds KEPT_SUMS only irregular;
    SCAN_KEPT_BLOCKS "scan_kept_blocks": SCAN over LEAF_BLOCKS binds ALL_KEPT_SUMS only irregular;
    GATHER_LEAVES "gather": GATHER over LEAVES renews MERGED only irregular;
    TURN_TO_NEXT_AXIS "next_axis": NEXT_AXIS over WHOLE only irregular;
    FOLLOW_LEAVES "follow": FOLLOW over REFINED renews ROUNDS only irregular;
    EXPAND_CELLS "expand": EXPAND over LEAVES adopts GATHERED only irregular;
    NAME_TOP "name_top": NAME_CELLS over CELLS binds OF_TOP only irregular;
    NAME_BLOCKS "name_blocks": NAME_CELLS over ENTRIES binds OF_BLOCKS only irregular;
    FINISH_EXPANDED "finish_cells": FINISH_CELLS over LEAVES binds AS_EXPANDED only irregular;
    FINISH_LEAVES "finish_leaves": FINISH_CELLS over LEAVES binds AS_IT_IS only two_levels;
    FINISH_LISTS "finish_items": FINISH_ITEMS over LEAVES only divided;
    CHECK_LIST_STARTS "check_starts": CHECK_STARTS over CELLS binds OF_STARTS only uniform;
    CHECK_EVEN "check_even": CHECK_ITEMS over REFERENCES binds ITEMS_EVEN only uniform;
    CHECK_ODD "check_odd": CHECK_ITEMS over REFERENCES binds ITEMS_ODD only uniform;
    CHECK_LISTS "check_items": CHECK_ITEMS over LISTED binds OF_ITEMS only divided;
    CHECK_ALL_CELLS "check_cells": CHECK_CELLS over LEAVES binds OF_CELLS only divided;
    CHECK_TOP "check_top": CHECK_MAP over CELLS by 0 binds OF_TOP only divided;
    CHECK_BLOCKS "check_blocks": CHECK_MAP over ENTRIES by 1 binds OF_BLOCKS only divided;
}
