"""The lifecycle node: messages in, decisions out."""
