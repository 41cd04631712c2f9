mod choice;
mod expression;
mod graph;
mod plant;
mod recording;
mod terms;
mod typeset;
