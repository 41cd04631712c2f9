mod choice;
mod expression;
mod plant;
