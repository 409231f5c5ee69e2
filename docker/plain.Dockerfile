# Without an installation of ROS, which comes as wheels: x86-64 alone.
# docker build -f docker/plain.Dockerfile -t colortrack-plain .
# docker run --rm -v $PWD:/data colortrack-plain replay /data/ball.mp4
FROM python:3.12-slim
WORKDIR /src
COPY . .
RUN pip install --no-cache-dir '.[standalone,demo,replay]'
WORKDIR /data
CMD ["pipeline"]
