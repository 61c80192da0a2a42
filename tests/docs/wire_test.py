"""Tests that the wire has all fields, values and calls that earlier releases had, unchanged."""

import pathlib
import unittest

import wire

ROOT = pathlib.Path(__file__).resolve().parents[2]
# What went, and what that means: docs/upgrade.md.
EXCUSED = ("WatchMapResponse.Island 4 one bool resumed",)
PROTO = """
message A {
  // x = 7;
  map<string, B> labels = 1;
  oneof part { C.D c = 2; }
  enum E { E_NONE = 0; E_ONE = 1; }
  message F { repeated fixed64 ids = 3 [packed = true]; reserved 4; }
}
extend google.protobuf.MethodOptions { A access = 7; }
service S { rpc Do(stream A) returns (A) { option (access) = {ids: 1 part: "x"}; } rpc Be(A) returns (stream A) {} }
"""


class WireTest(unittest.TestCase):

    def test_nothing_that_was_told_once_is_told_otherwise(self):
        now = wire.read_folder(ROOT / "proto/corbslam/v1")
        lists = sorted((ROOT / "tests/data/golden").glob("wire_*.txt"))
        self.assertGreaterEqual(len(lists), 2)
        for file in lists:
            before = file.read_text(encoding="utf-8").splitlines()
            self.assertGreater(len(before), 200)
            self.assertEqual([], wire.find_gone(before, now, EXCUSED), file.name)

    def test_reads_fields_values_and_calls(self):
        self.assertEqual(["A 1 one map<string,B> labels", "A 2 one C.D c", "A.E 0 E_NONE",
                          "A.E 1 E_ONE", "A.F 3 repeated fixed64 ids", "S/Do (stream A) (A)",
                          "S/Be (A) (stream A)"], wire.read_proto(PROTO))

    def test_another_number_type_or_name_is_found(self):
        before = wire.read_proto("message A { uint32 x = 1; }")
        for now in ("uint32 x = 2;", "uint64 x = 1;", "uint32 y = 1;", "repeated uint32 x = 1;", ""):
            self.assertEqual(before, wire.find_gone(before, wire.read_proto(f"message A {{ {now} }}")))
        more = wire.read_proto("message A { uint32 x = 1; uint32 y = 2; }")
        self.assertEqual([], wire.find_gone(before, more))


if __name__ == "__main__":
    unittest.main()
