//! Tests the queue of packets that wait to be sent.

use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use mocap_cli::internals::packets::{LONGEST, MOST_WAITING, OF_PACKET, Packet, Packets};

/// Sends packets of one size to a receiver that takes none. Returns the numbers of kept and dropped packets.
fn kept_and_lost(count: usize, size: usize) -> (usize, u64) {
    let is_over = Arc::new(AtomicBool::new(false));
    let packets = Packets::of("vmc:127.0.0.1:0".parse().unwrap(), Arc::clone(&is_over), None)
        .ok()
        .unwrap();
    let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
    let shared = &packets.shared;
    let heard = || shared.waiting.load(Ordering::Relaxed) / (size + OF_PACKET) + packets.lost() as usize;
    for sent in 0..count {
        let number = u8::try_from(sent % 256).unwrap();
        sender.send_to(&vec![number; size], packets.address()).unwrap();
        // A busy system may drop fast packets.
        while heard() <= sent {
            thread::yield_now();
        }
    }
    is_over.store(true, Ordering::Relaxed);
    let kept: Vec<Packet> = (&packets).collect();
    assert!(
        kept.iter()
            .zip(0..)
            .all(|(packet, number)| packet.bytes[0] == (number % 256) as u8)
    );
    assert!(kept.is_sorted_by_key(|packet| packet.seconds));
    (kept.len(), packets.lost())
}

#[test]
fn packets_wait_for_those_before_them() {
    assert_eq!(kept_and_lost(2000, 40), (2000, 0));
}

#[test]
fn what_waits_is_bounded_and_the_rest_is_counted() {
    let (kept, lost) = kept_and_lost(400, 60_000);
    assert!(kept * 60_000 < MOST_WAITING + 2 * LONGEST && kept > 200, "{kept}");
    assert_eq!(kept + usize::try_from(lost).unwrap(), 400);
}
