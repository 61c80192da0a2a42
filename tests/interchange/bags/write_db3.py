#!/usr/bin/python3
"""Writes CDR of write_mcap.mjs as rosbag2's SQLite storage lays it out, with its metadata.yaml.

    write_db3.py FILE.cdr FOLDER [--files N] [--pack]    # --pack: each message by zstd (python3-zstandard)
"""
import argparse
import json
import sqlite3
from pathlib import Path

TABLES = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                    serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
                      data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


def write_file(path, lines, cdr, pack):
    database = sqlite3.connect(path)
    database.executescript(TABLES)
    database.execute("INSERT INTO schema VALUES (3, 'humble')")
    topics = {}
    for line in lines:
        if line["topic"] not in topics:
            topics[line["topic"]] = len(topics) + 1
            database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')",
                             (topics[line["topic"]], line["topic"], line["type"]))
        cdr.seek(line["offset"])
        database.execute("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                         (topics[line["topic"]], int(line["time_ns"]), pack(cdr.read(line["size"]))))
    database.commit()
    database.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cdr")
    parser.add_argument("folder")
    parser.add_argument("--files", type=int, default=1)
    parser.add_argument("--pack", action="store_true")
    arguments = parser.parse_args()
    pack = bytes
    if arguments.pack:
        import zstandard
        pack = zstandard.ZstdCompressor().compress
    lines = [json.loads(line) for line in open(f"{arguments.cdr}.jsonl")]
    folder = Path(arguments.folder)
    folder.mkdir(parents=True)
    names = [f"{folder.name}_{i}.db3" for i in range(arguments.files)]
    with open(arguments.cdr, "rb") as cdr:
        for i, name in enumerate(names):
            share = lines[i * len(lines) // len(names):(i + 1) * len(lines) // len(names)]
            write_file(folder / name, share, cdr, pack)
    with open(folder / "metadata.yaml", "w") as file:
        file.write("rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"
                   "  relative_file_paths:\n" + "".join(f"    - {name}\n" for name in names) +
                   f"  message_count: {len(lines)}\n"
                   f"  compression_format: \"{'zstd' if arguments.pack else ''}\"\n"
                   f"  compression_mode: \"{'MESSAGE' if arguments.pack else ''}\"\n")


main()
