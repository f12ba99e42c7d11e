//! Wavelet transport: one bounce between some quads and all bounces of some functions, computed again.

use super::Again;
use crate::wavelet::{TransportSettings, direct_transport_between};
use glam::Vec3;
use lapidary_core::{
    offset,
    wavelet::{WaveletTransport, operator::TransportCoefficient, series::Column},
};
use serde::Serialize;

/// Results of a verification of wavelet transport.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WaveletVerification {
    /// Pairs of quads whose transport was computed again.
    pub pairs: usize,
    /// Number of these pairs with other coefficients.
    pub different_pairs: usize,
    /// Functions whose light was bounced again, and number of these with other light.
    pub senders: [usize; 2],
}

impl WaveletVerification {
    /// `None` without wavelet transport.
    pub(super) fn of(again: &Again) -> Option<Self> {
        let transport = again.dataset.wavelet.as_deref()?;
        let scene = &again.dataset.scene;
        let quads = transport.patches.len();
        let is_shown = |index: usize| {
            let ends = [index / quads, index % quads].map(|end| transport.patches[end].patch.object);
            ends.iter().all(|object| !scene.hidden.contains_key(object))
        };
        let all = (0..quads * quads).filter(|&pair| is_shown(pair));
        let picked = again.random().choose_multiple(all, again.count.min(quads * quads));
        let offset = offset::TRANSPORT * scene.mesh.bounds().diagonal();
        let settings = TransportSettings::compressed(again.dataset.settings.wavelet.compression);
        let differs = |&&pair: &&usize| {
            let made = direct_transport_between(&transport.patches, pair, again.intersector, offset, &settings);
            !agree(made, stored(transport, pair))
        };
        let compressed = transport.direct.compressed(settings.compression);
        let senders =
            again.random().choose_multiple(0..compressed.functions(), again.count.min(compressed.functions()));
        let bounces_otherwise = |&&sender: &&usize| {
            let made = Column::of(&compressed, sender, settings.compression).sum;
            !is_same_column(&made, transport.global.column(sender))
        };
        Some(Self {
            pairs: picked.len(),
            different_pairs: picked.iter().filter(differs).count(),
            senders: [senders.len(), senders.iter().filter(bounces_otherwise).count()],
        })
    }

    /// Whether the coefficients agree.
    pub(super) fn agrees(&self) -> bool {
        self.different_pairs == 0 && self.senders[1] == 0
    }

    /// The result in a sentence, on a line.
    pub(super) fn text(&self) -> String {
        let Self { pairs, different_pairs, senders: [senders, different_senders] } = self;
        format!(
            "computed the transport of {pairs} pairs of quads again: {different_pairs} differ; bounced the light of {senders} functions \
             again: {different_senders} differ\n"
        )
    }
}

/// The stored coefficients between the quads of a pair, in the order of senders and receivers.
fn stored(transport: &WaveletTransport, pair: usize) -> Vec<TransportCoefficient> {
    let functions = transport.basis.functions();
    let [to, from] = [pair / transport.patches.len(), pair % transport.patches.len()].map(|patch| patch as u32);
    let senders = (0..functions.len()).filter(|&sender| functions[sender].patch == from);
    let of_sender = |sender: usize| {
        let entries = transport.direct.column(sender).iter();
        entries.map(move |&(receiver, value)| TransportCoefficient {
            receiver: functions[receiver as usize],
            sender: functions[sender],
            value,
        })
    };
    senders.flat_map(of_sender).filter(|coefficient| coefficient.receiver.patch == to).collect()
}

/// Whether two columns are the same but for rounding.
fn is_same_column(made: &[(u32, Vec3)], stored: &[(u32, Vec3)]) -> bool {
    made.len() == stored.len() && made.iter().zip(stored).all(|(a, b)| a.0 == b.0 && a.1.abs_diff_eq(b.1, 1e-6))
}

/// Whether two lists have the same coefficients but for rounding.
fn agree(mut made: Vec<TransportCoefficient>, stored: Vec<TransportCoefficient>) -> bool {
    made.sort_unstable_by_key(|coefficient| (coefficient.sender, coefficient.receiver));
    let is_same = |(a, b): (&TransportCoefficient, &TransportCoefficient)| {
        a.sender == b.sender && a.receiver == b.receiver && a.value.abs_diff_eq(b.value, 1e-6)
    };
    made.len() == stored.len() && made.iter().zip(&stored).all(is_same)
}
