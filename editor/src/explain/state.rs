//! The explained pixel, and its explanation.

use crate::{explain::panel::ExplainPanel, viewport::compare::NodeMark};
use lapidary_render::{ErrorSplit, TreeOf};
use lapidary_studies::jobs::explain::{ExplainJob, ExplainedPicture, ExplainedPixel};

/// Nodes that are drawn over the picture: those with the largest contributions.
const DRAWN: usize = 64;

/// The present explanation, and the one in progress.
#[derive(Default)]
pub struct ExplainWindow {
    pub panel: ExplainPanel,
    pub open: bool,
    pub pixel: Option<[u32; 2]>,
    /// The picture in which it was chosen.
    pub picture: Option<ExplainedPicture>,
    /// The shown tree, if there are both.
    pub tree: Option<TreeOf>,
    pub job: Option<ExplainJob<ExplainedPixel>>,
    pub splitting: Option<ExplainJob<Option<ErrorSplit>>>,
    pub explained: Option<ExplainedPixel>,
    pub split: Option<ErrorSplit>,
    pub message: Option<String>,
}

impl ExplainWindow {
    /// The explained pixel, for a mark in the viewport.
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.pixel.filter(|_| self.open)
    }

    /// Nodes on surfaces from which the pixel's light comes.
    pub fn marks(&self) -> Vec<NodeMark> {
        let Some(ExplainedPixel { explanation, .. }) = self.explained.as_ref().filter(|_| self.open) else {
            return Vec::new();
        };
        let contribution = |i: usize| lapidary_core::color::luminance(explanation.nodes[i].contribution);
        let order = explanation.by_contribution();
        let largest = order.first().map_or(1.0, |&i| contribution(i)).max(f32::MIN_POSITIVE);
        let hovered = self.panel.hovered_node();
        let mark = |&i: &usize| {
            let center = explanation.nodes[i].center?;
            Some(NodeMark { center, share: contribution(i) / largest, hovered: hovered == Some(i) })
        };
        order.iter().take(DRAWN).filter_map(mark).collect()
    }

    /// Whether a pixel has been explained.
    #[cfg(test)]
    pub fn has_nodes(&self) -> bool {
        self.explained.as_ref().is_some_and(|e| !e.explanation.nodes.is_empty())
    }

    /// Number of causes in the last split.
    #[cfg(test)]
    pub fn causes(&self) -> usize {
        self.split.as_ref().map_or(0, |split| split.steps.len())
    }

    /// Why there is no explanation.
    #[cfg(test)]
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    pub fn take(&mut self) {
        if let Some(answer) = self.job.as_ref().and_then(ExplainJob::answer) {
            self.job = None;
            match answer {
                Ok(explained) => (self.explained, self.message) = (Some(explained), None),
                Err(text) => (self.explained, self.message) = (None, Some(text)),
            }
        }
        if let Some(answer) = self.splitting.as_ref().and_then(ExplainJob::answer) {
            self.splitting = None;
            match answer {
                Ok(split) => self.split = split,
                Err(text) => self.message = Some(text),
            }
        }
    }
}
