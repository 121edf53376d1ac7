"""The whole story on a simulated arm that hides an effect, over HTTP and CAN."""
