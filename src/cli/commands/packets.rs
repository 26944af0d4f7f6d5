//! The packets of a port. A thread of its own hears them, so that none is lost while those before are worked on.

use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use mocap::{Code, Diagnostic, Error};

use crate::Failure;
use crate::args::Listen;

/// Bytes of the longest packet of UDP.
const LONGEST: usize = 65_536;

/// Bytes of the packets that wait at most: 50 seconds of a sender of 60 poses a second.
const MOST_WAITING: usize = 16 << 20;

/// Bytes that a packet takes besides its own.
const OF_PACKET: usize = 64;

/// How long to wait for a packet before looking whether to end.
pub(super) const PATIENCE: Duration = Duration::from_millis(50);

/// A packet, and how many seconds after the beginning it came.
pub(super) struct Packet {
    pub(super) bytes: Vec<u8>,
    pub(super) seconds: f64,
}

/// The packets as they come, to the end of listening and of what waits then.
pub(super) struct Packets {
    address: SocketAddr,
    heard: Receiver<Packet>,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    waiting: AtomicUsize,
    lost: AtomicU64,
}

impl Packets {
    /// Listens until it is over, or for so many seconds.
    pub(super) fn of(source: Listen, is_over: Arc<AtomicBool>, seconds: Option<f64>) -> Result<Self, Failure> {
        let socket = UdpSocket::bind(source.0).map_err(|error| of_socket(source.0, &error))?;
        socket.set_read_timeout(Some(PATIENCE))?;
        let (sender, heard) = channel();
        let shared = Arc::<Shared>::default();
        let packets = Self {
            // A port of 0 is one that the system chooses.
            address: socket.local_addr()?,
            heard,
            shared: Arc::clone(&shared),
        };
        let listen = move || hear(&socket, &sender, &shared, &is_over, seconds);
        thread::Builder::new().spawn(listen)?;
        Ok(packets)
    }

    /// Where it listens.
    pub(super) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Packets that came and were not kept, because too many waited.
    pub(super) fn lost(&self) -> u64 {
        self.shared.lost.load(Ordering::Relaxed)
    }
}

impl Iterator for &Packets {
    type Item = Packet;

    fn next(&mut self) -> Option<Packet> {
        let packet = self.heard.recv().ok()?;
        let taken = packet.bytes.len() + OF_PACKET;
        self.shared.waiting.fetch_sub(taken, Ordering::Relaxed);
        Some(packet)
    }
}

fn hear(socket: &UdpSocket, sender: &Sender<Packet>, shared: &Shared, is_over: &AtomicBool, seconds: Option<f64>) {
    let mut buffer = vec![0; LONGEST];
    let begin = Instant::now();
    let is_late = || seconds.is_some_and(|seconds| begin.elapsed().as_secs_f64() >= seconds);
    while !is_over.load(Ordering::Relaxed) && !is_late() {
        // One that fails, as when a peer has gone, does not end it.
        let Ok((length, _)) = socket.recv_from(&mut buffer) else {
            continue;
        };
        let taken = length + OF_PACKET;
        if shared.waiting.fetch_add(taken, Ordering::Relaxed) > MOST_WAITING {
            shared.waiting.fetch_sub(taken, Ordering::Relaxed);
            shared.lost.fetch_add(1, Ordering::Relaxed);
            continue;
        }
        let packet = Packet {
            bytes: buffer[..length].to_vec(),
            seconds: begin.elapsed().as_secs_f64(),
        };
        // Nobody takes them any more.
        if sender.send(packet).is_err() {
            return;
        }
    }
}

pub(super) fn of_socket(address: SocketAddr, error: &io::Error) -> Error {
    let diagnostic = Diagnostic::new(Code::Io, format!("{address}: {error}"));
    Error::from(diagnostic.help("choose an address of this machine and a port that no other program has"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sends packets of one size to somebody who takes none, and gives how many are kept then, and how many are not.
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
            // The system loses what comes faster than a machine that does other work listens.
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
}
