#!/usr/bin/env bash
# Guess: A subscriber of iceoryx2 that reads late gets all samples sent since it is there, or send() says that it did not.
# Package: PyPI iceoryx2 0.10.0
# Seen: The last two of ten; send() says of each that one subscriber got it. The buffer of a subscriber has two places by default,
#   and a full one drops its oldest sample (enable_safe_overflow). Without overflow send() says 0 from the third on.
# Source: config/README.md of iceoryx2, defaults.publish-subscribe (subscriber-max-buffer-size, enable-safe-overflow); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q iceoryx2==0.10.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import ctypes

import iceoryx2

iceoryx2.set_log_level(iceoryx2.LogLevel.Error)


def sent_and_got(name, overflow):
    node = iceoryx2.NodeBuilder.new().create(iceoryx2.ServiceType.Local)
    builder = node.service_builder(iceoryx2.ServiceName.new(name)).publish_subscribe(ctypes.c_uint64)
    if not overflow:
        builder = builder.enable_safe_overflow(False)
    service = builder.open_or_create()
    subscriber = service.subscriber_builder().create()
    publisher = service.publisher_builder()
    if not overflow:
        publisher = publisher.backpressure_strategy(iceoryx2.BackpressureStrategy.DiscardData)
    publisher = publisher.create()
    sent = [publisher.loan_uninit().write_payload(ctypes.c_uint64(n)).send() for n in range(10)]
    got = []
    while (sample := subscriber.receive()) is not None:
        got.append(sample.payload().contents.value)
    return sent, got


found = sent_and_got("plain", True), sent_and_got("careful", False)
print(*found)
assert found == (([1] * 10, [8, 9]), ([1, 1] + [0] * 8, [0, 1])), "the behaviour has changed"
PYTHON
