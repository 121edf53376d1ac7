"""metadata.yaml, by which rosbag2 and its relatives recognise a folder as a bag."""

from __future__ import annotations

import json
from pathlib import Path

from pa10d.store.folders import write_text
from pa10d.store.mcap_records import Index


def write_bag_metadata(folder: Path, file_name: str, index: Index) -> None:
    """Describe the bag's one file (rosbag2 format 6). JSON is YAML that needs no library."""
    start = index.start or 0
    span = {
        "starting_time": {"nanoseconds_since_epoch": start},
        "duration": {"nanoseconds": max(0, index.end - start)},
        "message_count": sum(index.messages.values()),
    }
    topics = [
        {
            "topic_metadata": {
                "name": topic,
                "type": message_type,
                "serialization_format": "cdr",
                "offered_qos_profiles": "",
            },
            "message_count": index.messages[number],
        }
        for number, (topic, message_type) in index.topics.items()
    ]
    information = {
        "version": 6,
        "storage_identifier": "mcap",
        **span,
        "topics_with_message_count": topics,
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [{"path": file_name, **span}],
        "custom_data": None,
    }
    document = {"rosbag2_bagfile_information": information}
    write_text(folder / "metadata.yaml", json.dumps(document, indent=1) + "\n")
